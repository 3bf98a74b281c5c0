/* Finds one fruit and prints it: values for people, bits for comparison between machines.
 *
 * The cloud is the nearer half of a jujube, 22 x 11 x 11 mm, 700 mm before the camera, made with additions,
 * multiplications and divisions only, so that it is the same on every machine (build with -ffp-contract=off: a
 * compiler that fuses multiplications and additions would make another cloud). */
#include <stdio.h>
#include <string.h>

#include "varsac.h"

#define POINTS 200

VARSAC_WORKSPACE(workspace, POINTS);

static varsac_point_t cloud[POINTS];

/* Stereographic projection: u and v inside the unit circle lead to the half sphere that faces the camera. */
static void make_cloud(void) {
    uint32_t state = 1, count = 0;
    while (count < POINTS) {
        float uv[2];
        for (int k = 0; k < 2; k++) {
            state = state * 1664525u + 1013904223u;
            uv[k] = (float)(state >> 8) / 8388608.0f - 1.0f;
        }
        const float square = uv[0] * uv[0] + uv[1] * uv[1];
        if (square < 1.0f) {
            const float scale = 1.0f / (1.0f + square);
            cloud[count].x = 22.0f * (2.0f * uv[0] * scale);
            cloud[count].y = 11.0f * (2.0f * uv[1] * scale);
            cloud[count].z = 700.0f - 11.0f * ((1.0f - square) * scale);
            count++;
        }
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

static int fail(const char *where, varsac_status_t status) {
    printf("%s: %s\n", where, varsac_status_text(status));
    return 1;
}

int main(void) {
    if (varsac_version() != VARSAC_VERSION) {
        printf("header and library are of different versions\n");
        return 1;
    }
    make_cloud();

    varsac_config_t config;
    varsac_status_t status = varsac_config_preset(VARSAC_PRESET_JUJUBE, &config);
    if (status != VARSAC_OK) return fail("preset", status);

    /* All at once. */
    varsac_detection_t fruit[4];
    uint32_t found = 0;
    status = varsac_detect(&config, cloud, POINTS, &workspace, 1, fruit, 4, &found);
    if (status != VARSAC_OK) return fail("detect", status);
    printf("found %lu\n", (unsigned long)found);
    if (found == 0) return 1;
    print_floats("centre_mm", fruit[0].centre_mm, 3);
    print_floats("semi_axes_mm", fruit[0].semi_axes_mm, 3);
    print_floats("axes", &fruit[0].axes[0][0], 9);
    print_floats("quaternion_xyzw", fruit[0].quaternion_xyzw, 4);
    printf("inliers %lu of %lu, %lu trials\n", (unsigned long)fruit[0].inliers, (unsigned long)fruit[0].candidates,
           (unsigned long)fruit[0].trials);

    /* The same step by step: between two steps a controller does its other work. */
    static varsac_search_t search;
    varsac_detection_t again;
    uint32_t steps = 0;
    status = varsac_begin(&search, &config, cloud, POINTS, &workspace, 1);
    if (status != VARSAC_OK) return fail("begin", status);
    do {
        status = varsac_step(&search, &again);
        steps++;
    } while (status == VARSAC_WORKING);
    if (status != VARSAC_FOUND) return fail("step", status);
    printf("step by step: %s after %lu steps\n",
           memcmp(&again, &fruit[0], sizeof again) == 0 ? "the same bits" : "OTHER BITS", (unsigned long)steps);

    /* Mistakes come back as codes. */
    config.shell = 2.0f;
    status = varsac_detect(&config, cloud, POINTS, &workspace, 1, fruit, 4, &found);
    printf("a shell of 2: %s: %s\n", varsac_status_text(status), varsac_config_problem(&config));
    return memcmp(&again, &fruit[0], sizeof again) == 0 && status == VARSAC_ERROR_CONFIGURATION ? 0 : 1;
}
