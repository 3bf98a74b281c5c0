/* Finds one fruit in what a depth camera sees of it and prints it: values for people, bits for comparison between machines.
 *
 * The view is a jujube, 21.75 x 10.9 x 10.9 mm, 680 mm before a camera with a focal length of 365 pixels, and a wall 100 mm
 * behind. It is made with additions, multiplications, divisions and a square root of its own, so that it is the same on
 * every machine (build with -ffp-contract=off: a compiler that fuses multiplications and additions would make another). */
#include <stdio.h>
#include <string.h>

#include "varsac.h"

#define SIDE 48
#define POINTS 400
#define RAYS 128
#define FOCAL_PX 365.0f
#define WALL_MM 780.0f

VARSAC_WORKSPACE(workspace, POINTS);

static float depth_mm[SIDE][SIDE]; /* 0: not on the fruit */
static varsac_point_t points[POINTS];
static varsac_outline_ray_t outline[RAYS];
static varsac_view_t view = {points, outline, 0, 0, 0, 1.0f / FOCAL_PX};

/* Newton's method from above, until it no longer falls. */
static float square_root(float x) {
    float root = x > 1.0f ? x : 1.0f;
    for (;;) {
        const float next = 0.5f * (root + x / root);
        if (next >= root) return root;
        root = next;
    }
}

/* Depth of the ellipsoid (long axis along (0.6, 0.8, 0)) on the ray through (x, y, 1), or 0. */
static float fruit_depth(float x, float y) {
    const float centre_mm = 680.0f, half_long = 21.75f, half_short = 10.9f;
    const float ray[3] = {(0.6f * x + 0.8f * y) / half_long, (0.6f * y - 0.8f * x) / half_short, 1.0f / half_short};
    const float behind = centre_mm / half_short; /* the centre lies on the optical axis */
    const float a = ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2];
    const float b = ray[2] * behind;
    const float discriminant = b * b - a * (behind * behind - 1.0f);
    return discriminant > 0.0f ? (b - square_root(discriminant)) / a : 0.0f;
}

static float tangent(int pixel, float offset) {
    return ((float)pixel + offset - 0.5f * (float)(SIDE - 1)) / FOCAL_PX;
}

static void add_point(int u, int v, float z) {
    if (view.point_count < POINTS) {
        const varsac_point_t point = {z * tangent(u, 0.0f), z * tangent(v, 0.0f), z};
        points[view.point_count++] = point;
    }
}

static void add_ray(int u, int v, int du, int dv) {
    if (view.outline_count < RAYS) {
        const float z = depth_mm[v][u];
        const varsac_point_t inner = {z * tangent(u, 0.5f * (float)du), z * tangent(v, 0.5f * (float)dv), z};
        const varsac_outline_ray_t ray = {inner, WALL_MM, 0.4f / FOCAL_PX};
        outline[view.outline_count++] = ray;
    }
}

/* First the points on the fruit, and between each of them and the wall beside it an outline ray; then the wall around it. */
static void make_view(void) {
    static const int step[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (int v = 0; v < SIDE; v++)
        for (int u = 0; u < SIDE; u++) depth_mm[v][u] = fruit_depth(tangent(u, 0.0f), tangent(v, 0.0f));
    for (int wall = 0; wall < 2; wall++) {
        const uint32_t before = view.point_count;
        for (int v = 1; v < SIDE - 1; v++)
            for (int u = 1; u < SIDE - 1; u++) {
                int beside = 0;
                for (int k = 0; k < 4; k++) {
                    const int other = depth_mm[v + step[k][1]][u + step[k][0]] > 0.0f;
                    beside |= other;
                    if (!wall && depth_mm[v][u] > 0.0f && !other) add_ray(u, v, step[k][0], step[k][1]);
                }
                if (!wall && depth_mm[v][u] > 0.0f) add_point(u, v, depth_mm[v][u]);
                if (wall && !(depth_mm[v][u] > 0.0f) && beside) add_point(u, v, WALL_MM);
            }
        if (wall) view.outside_mask = view.point_count - before;
    }
}

static void print_floats(const char *name, const float *values, int count) {
    printf("%s", name);
    for (int k = 0; k < count; k++) {
        uint32_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        printf(" %.4f=%08lx", (double)values[k], (unsigned long)bits);
    }
    printf("\n");
}

static void print_fruit(const varsac_detection_t *fruit) {
    printf("fruit %lu: %s", (unsigned long)fruit->target, varsac_verdict_text(fruit->verdict));
    if (fruit->verdict != VARSAC_ACCEPTED)
        printf(", %.3f with a limit of %.3f", (double)fruit->refusal_value, (double)fruit->refusal_limit);
    printf("\n");
    print_floats("centre_mm", fruit->centre_mm, 3);
    print_floats("sigma_centre_mm", fruit->sigma_centre_mm, 3);
    print_floats("semi_axes_mm", fruit->semi_axes_mm, 3);
    print_floats("axes", &fruit->axes[0][0], 9);
    print_floats("quaternion_xyzw", fruit->quaternion_xyzw, 4);
    print_floats("covariance of the centre", fruit->covariance, 6);
    printf("inliers %lu of %lu, %lu trials\n", (unsigned long)fruit->inliers, (unsigned long)fruit->candidates,
           (unsigned long)fruit->trials);
}

static int fail(const char *where, varsac_status_t status) {
    printf("%s: %s\n", where, varsac_status_text(status));
    return 1;
}

int main(void) {
    if (varsac_version() != VARSAC_VERSION) {
        printf("header and library are of different versions\n");
        return 1;
    }
    make_view();
    printf("%lu points, %lu of them beside the fruit, %lu outline rays\n", (unsigned long)view.point_count,
           (unsigned long)view.outside_mask, (unsigned long)view.outline_count);

    varsac_config_t config;
    varsac_status_t status = varsac_config_preset(VARSAC_PRESET_JUJUBE, &config);
    if (status != VARSAC_OK) return fail("preset", status);

    /* All at once, by the default search. */
    static varsac_detection_t fruit[4];
    uint32_t found = 0;
    status = varsac_detect(&config, &view, &workspace, 1, fruit, 4, &found);
    if (status != VARSAC_OK) return fail("detect", status);
    printf("found %lu\n", (unsigned long)found);
    if (found == 0) return 1;
    print_fruit(&fruit[0]);

    /* The same step by step: between two steps a controller does its other work. */
    static varsac_search_t search;
    static varsac_detection_t again;
    uint32_t steps = 0;
    status = varsac_begin(&search, &config, &view, &workspace, 1);
    if (status != VARSAC_OK) return fail("begin", status);
    do {
        status = varsac_step(&search, &again);
        steps++;
    } while (status == VARSAC_WORKING);
    if (status != VARSAC_FOUND) return fail("step", status);
    const int same = memcmp(&again, &fruit[0], sizeof again) == 0;
    printf("step by step: %s after %lu steps\n", same ? "the same bits" : "OTHER BITS", (unsigned long)steps);

    /* A robot that must be surer of the centre than this view allows: the fruit is refused, and it is said why. */
    config.map.gate.uncertain_mm = 0.5f * fruit[0].sigma_centre_mm[2];
    status = varsac_detect(&config, &view, &workspace, 1, &again, 1, &found);
    if (status != VARSAC_OK || found != 1) return fail("stricter", status);
    const int refused = again.verdict == VARSAC_REFUSED_UNCERTAIN;
    print_fruit(&again);

    /* The paper's search for the same fruit, without a size prior, an outline or a verdict. */
    config.method = VARSAC_METHOD_VARSAC;
    status = varsac_detect(&config, &view, &workspace, 1, &again, 1, &found);
    if (status != VARSAC_OK) return fail("paper", status);
    printf("the paper's search: found %lu\n", (unsigned long)found);
    if (found > 0) print_fruit(&again);

    /* Mistakes come back as codes. */
    config.map.gate.flat = -1.0f;
    status = varsac_detect(&config, &view, &workspace, 1, fruit, 4, &found);
    printf("a limit of -1: %s: %s\n", varsac_status_text(status), varsac_config_problem(&config));
    return same && refused && status == VARSAC_ERROR_CONFIGURATION ? 0 : 1;
}
