/* varsac: finds ellipsoidal fruit in point clouds. No heap, no globals, bounded work, the same bits on every machine.
 *
 * Lengths are in millimetres, points in the camera's optical frame: x right, y down, z forward.
 * Nothing here is thread-safe by itself and nothing needs to be: all memory is the caller's, so two searches with
 * two workspaces can run at the same time.
 *
 * Link with libvarsac.a. Do not switch flush-to-zero on (-ffast-math may do so): results would differ.
 */
#ifndef VARSAC_H
#define VARSAC_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#define VARSAC_ASSERT(condition, text) static_assert(condition, text)
#else
#define VARSAC_ASSERT(condition, text) _Static_assert(condition, text)
#endif

/* Version of this header: major, minor, patch. Compare with varsac_version(), the library's. */
#define VARSAC_VERSION_OF(major, minor, patch) (((uint32_t)(major) << 16) | ((uint32_t)(minor) << 8) | (uint32_t)(patch))
#define VARSAC_VERSION VARSAC_VERSION_OF(0, 1, 0)
uint32_t varsac_version(void);

/* Outcome of a call. Negative: an error, and nothing was done. */
typedef int32_t varsac_status_t;
enum {
    VARSAC_OK = 0,
    VARSAC_WORKING = 1,             /* varsac_step: there is more to do */
    VARSAC_FOUND = 2,               /* varsac_step: a target was found */
    VARSAC_FINISHED = 3,            /* varsac_step: the search is over */
    VARSAC_ERROR_ARGUMENT = -1,     /* a pointer is null or a number is out of range */
    VARSAC_ERROR_CONFIGURATION = -2,/* a field of the configuration is out of range */
    VARSAC_ERROR_COORDINATE = -3,   /* a coordinate is not finite or beyond 1e9 */
    VARSAC_ERROR_CAPACITY = -4      /* more points than the workspace holds */
};

/* A sentence for a status; never null. It is in flash only if you call this. */
const char *varsac_status_text(varsac_status_t status);

typedef struct varsac_point {
    float x, y, z;
} varsac_point_t;
VARSAC_ASSERT(sizeof(varsac_point_t) == 12, "three floats");

/* What steers a search. Start from a preset. */
typedef struct varsac_config {
    float confidence;           /* probability of having drawn a good sample when the search stops; inside (0, 1) */
    float shell;                /* d of the shell from 1 - d to 1 + d in which points count; inside (0, 1) */
    float radius;               /* r_s, sampling radius; positive, INFINITY means the whole cloud */
    float semi_axis_min;        /* semi-axes must be longer than this */
    float semi_axis_max;        /* and shorter than this */
    float min_ratio;            /* part of its neighbourhood a hypothesis must explain; 0 to 1 */
    uint32_t max_trials;        /* hypotheses per target at most; 1 to 1000000 */
    uint16_t min_inliers;       /* points that must support a target; 1 to 65535 */
    uint8_t refits;             /* least-squares refits of the best hypothesis; 0 to 10 */
    uint8_t max_targets;        /* 1 to 255 */
    uint8_t max_failures;       /* searches without a result after which the cloud is given up; 1 to 255 */
    uint8_t constraint;         /* 0: a11 = 1 (the paper); 1: unit trace (the same answer in every frame) */
    uint8_t sample_size_count;  /* 1 to 16 */
    uint8_t sample_sizes[16];   /* 9 to 32 each, tried in turn */
    uint8_t reserved;           /* 0 */
} varsac_config_t;
VARSAC_ASSERT(sizeof(varsac_config_t) == 52, "no padding");
VARSAC_ASSERT(offsetof(varsac_config_t, sample_sizes) == 35, "no padding");

enum {
    VARSAC_PRESET_JUJUBE = 0,
    VARSAC_PRESET_APPLE = 1,
    VARSAC_PRESET_GENERIC = 2, /* fruit of 10 to 120 mm */
    VARSAC_PRESET_TABLE5 = 3,  /* jujubes with the paper's limits as printed */
    VARSAC_PRESET_TABLE2 = 4   /* the paper's simulation */
};
varsac_status_t varsac_config_preset(uint32_t preset, varsac_config_t *config);

/* Name of the first field that is out of range, or null. */
const char *varsac_config_problem(const varsac_config_t *config);

/* One fruit. */
typedef struct varsac_detection {
    float centre_mm[3];
    float semi_axes_mm[3];     /* longest first */
    float axes[3][3];          /* row k: unit vector of semi-axis k; right-handed */
    float quaternion_xyzw[4];  /* attitude, w >= 0 */
    uint32_t inliers;          /* points that support it */
    uint32_t candidates;       /* points that could have */
    uint32_t trials;           /* hypotheses that were tried for it */
    uint32_t target;           /* 1, 2, ...: also the label of its points in the workspace */
} varsac_detection_t;
VARSAC_ASSERT(sizeof(varsac_detection_t) == 92, "no padding");

/* Memory of a search: 5 bytes a point. Use the macro, at file scope or inside a function:
 *     VARSAC_WORKSPACE(workspace, 2048);
 * After a search, workspace_labels[i] is 0 or the number of the target that claimed point i. */
typedef struct varsac_workspace {
    uint16_t *order;
    uint16_t *members;
    uint8_t *labels;
    uint32_t capacity;
} varsac_workspace_t;
#define VARSAC_WORKSPACE(name, points)                                                          \
    VARSAC_ASSERT((points) > 0 && (points) <= 65535, "1 to 65535 points");                      \
    static uint16_t name##_order[(points)];                                                     \
    static uint16_t name##_members[(points)];                                                   \
    static uint8_t name##_labels[(points)];                                                     \
    static const varsac_workspace_t name = {name##_order, name##_members, name##_labels, (points)}

/* Searches the cloud to the end, or until `capacity` targets are found, and writes their number to `found`.
 * The same points, configuration and seed give the same bits on every machine. */
varsac_status_t varsac_detect(const varsac_config_t *config, const varsac_point_t *points, uint32_t count,
                              const varsac_workspace_t *workspace, uint64_t seed, varsac_detection_t *detections,
                              uint32_t capacity, uint32_t *found);

/* The same in bounded pieces, for a loop that must not be held up. Memory of a search; its contents are private.
 * From varsac_begin on, do not move or change search, points or workspace until the search is over or given up;
 * to give it up, simply do not call varsac_step again. */
#define VARSAC_SEARCH_WORDS 80
typedef struct varsac_search {
    uint64_t words[VARSAC_SEARCH_WORDS];
} varsac_search_t;

varsac_status_t varsac_begin(varsac_search_t *search, const varsac_config_t *config, const varsac_point_t *points,
                             uint32_t count, const varsac_workspace_t *workspace, uint64_t seed);

/* One piece of work: VARSAC_WORKING, VARSAC_FOUND (and `detection`, if not null, is filled in), VARSAC_FINISHED. */
varsac_status_t varsac_step(varsac_search_t *search, varsac_detection_t *detection);

#ifdef __cplusplus
}
#endif
#endif
