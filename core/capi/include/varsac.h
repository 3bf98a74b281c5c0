/* varsac: finds ellipsoidal fruit in point clouds. No heap, no globals, bounded work, the same bits on every machine.
 *
 * Lengths are in millimetres, points in the camera's optical frame: x right, y down, z forward.
 * Nothing here is thread-safe by itself and nothing needs to be: all memory is the caller's, so two searches with
 * two workspaces can run at the same time.
 *
 * A search takes up to 8 KiB of stack on a Cortex-M.
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
    VARSAC_ERROR_CAPACITY = -4      /* more points than the workspace holds, or more than 4096 outline rays */
};

/* A sentence for a status; never null. It is in flash only if you call this. */
const char *varsac_status_text(varsac_status_t status);

typedef struct varsac_point {
    float x, y, z;
} varsac_point_t;
VARSAC_ASSERT(sizeof(varsac_point_t) == 12, "three floats");

/* An outline ray: it touches the rim of a fruit, between the last pixel on the fruit and the first one of what is behind. */
typedef struct varsac_outline_ray {
    varsac_point_t inner; /* point of the ray at the depth of the fruit's last pixel */
    float outer_mm;       /* depth (z) of what is behind; INFINITY where the camera saw nothing there */
    float sigma_rad;      /* standard deviation of the ray's direction */
} varsac_outline_ray_t;
VARSAC_ASSERT(sizeof(varsac_outline_ray_t) == 20, "five floats");

/* What a search looks at. What is not known is left 0. */
typedef struct varsac_view {
    const varsac_point_t *points;
    const varsac_outline_ray_t *outline; /* rays found in the depth image; may be null */
    uint32_t point_count;                /* at most 65535 */
    uint32_t outside_mask;               /* the last so many points are not of the fruit's colour: what is seen around it */
    uint32_t outline_count;              /* at most 4096 */
    float pitch_rad;                     /* angle between neighbouring points, 1 / focal length in pixels; 0: not known, and how
                                            much of a fruit is visible is not tested */
} varsac_view_t;
VARSAC_ASSERT(sizeof(varsac_view_t) == 16 + 2 * sizeof(void *), "no padding");

/* The size of a kind of fruit: logarithms of the semi-axes are normally distributed. */
typedef struct varsac_prior {
    float semi_axes_mm[3]; /* mean, longest first */
    float spread[3];       /* relative standard deviation of each; 0.05 is 5 % */
    float spread_ab;       /* of a / b; INFINITY: no such term */
    float spread_bc;       /* of b / c */
} varsac_prior_t;

/* How well the camera measures: standard deviations along and across the viewing ray. */
typedef struct varsac_noise {
    float axial_mm;
    float lateral_rad;
} varsac_noise_t;

/* Factor on the covariance: base + per_conflict * size conflict + per_clutter * clutter. */
typedef struct varsac_inflation {
    float base;
    float per_conflict;
    float per_clutter;
} varsac_inflation_t;

/* Limits of acceptance; INFINITY, or 0 where the limit is a lower one, switches a test off. See varsac_verdict_t. */
typedef struct varsac_gate {
    float size_conflict; /* chi-squared of three degrees of freedom */
    float size_conflict_end_on; /* the same for a fruit seen from its end, which looks like a ball there */
    float size_unknown;  /* relative standard deviation of the whole size */
    float ambiguous;     /* score of the best rival over the score */
    float outline;       /* mean of min(|f|, 3) over at least six outline rays */
    float visible;       /* explained over predicted pixels, a lower limit */
    float colour;        /* share of the explained points outside the mask */
    float uncertain_mm;  /* largest standard deviation of the centre */
    float flat;          /* rms from the best plane over rms from the model, a lower limit */
    float through;       /* points seen through it over points explained */
    float shared_volume; /* contact function with a target before, 1 = touching; a lower limit */
    uint16_t min_points; /* explained points, a lower limit */
    uint16_t reserved;   /* 0 */
} varsac_gate_t;

/* What steers the default search. */
typedef struct varsac_map {
    varsac_prior_t prior;
    float boxiness;             /* standard deviation of how much fuller than an ellipsoid the fruit are; 0: ellipsoids */
    varsac_noise_t noise;
    float independence;         /* how much a point tells beside one with noise of its own; above 0 to 1 */
    float outline_offset_rad;   /* standard deviation of the displacement common to all outline rays */
    varsac_inflation_t inflation;
    varsac_gate_t gate;
    uint16_t hypotheses;        /* per target; 1 to 1000 */
    uint8_t viewpoint;          /* 0: the points were seen from the origin; 1: from all around (a scanner) */
    uint8_t hypothesis_steps;   /* Gauss-Newton steps of each; 0 to 50 */
    uint8_t kept;               /* hypotheses refined; 1 to 8 */
    uint8_t refine_steps;       /* 1 to 50 */
    uint8_t final_steps;        /* 1 to 50 */
    uint8_t reserved;           /* 0 */
} varsac_map_t;
VARSAC_ASSERT(sizeof(varsac_map_t) == 120, "no padding");

/* Which search. */
enum {
    VARSAC_METHOD_MAP = 0,   /* the default: the most probable fruit of known size behind points seen from one side */
    VARSAC_METHOD_VARSAC = 1,/* the paper's: variable sample consensus with the shell of two ellipsoids */
    VARSAC_METHOD_MIXTURE = 2/* any ellipsoid, its size unknown: complete surfaces, or one view, as map.viewpoint says */
};

/* What steers a search. Start from a preset. */
typedef struct varsac_config {
    /* The paper's search. */
    float confidence;           /* probability of having drawn a good sample when the search stops; inside (0, 1) */
    float shell;                /* d of the shell from 1 - d to 1 + d in which points count; inside (0, 1) */
    float radius;               /* r_s, sampling radius; positive, INFINITY means the whole cloud */
    float semi_axis_min;        /* semi-axes must be longer than this */
    float semi_axis_max;        /* and shorter than this */
    float min_ratio;            /* part of its neighbourhood a hypothesis must explain; 0 to 1 */
    uint32_t max_trials;        /* hypotheses per target at most; 1 to 1000000 */
    uint16_t min_inliers;       /* points that must support a target; 1 to 65535 */
    uint8_t refits;             /* least-squares refits of the best hypothesis; 0 to 10 */
    /* All searches. */
    uint8_t max_targets;        /* 1 to 255; the default search finds at most 32 */
    uint8_t max_failures;       /* searches without a result after which the cloud is given up; 1 to 255 */
    /* The paper's search. */
    uint8_t constraint;         /* 0: a11 = 1 (the paper); 1: unit trace (the same answer in every frame) */
    uint8_t sample_size_count;  /* 1 to 16 */
    uint8_t sample_sizes[16];   /* 9 to 32 each, tried in turn */
    /* Which search: VARSAC_METHOD_MAP, VARSAC_METHOD_VARSAC or VARSAC_METHOD_MIXTURE. */
    uint8_t method;
    /* The default search; without a size prior, viewpoint and noise are those of the mixture. */
    varsac_map_t map;
} varsac_config_t;
VARSAC_ASSERT(sizeof(varsac_config_t) == 172, "no padding");
VARSAC_ASSERT(offsetof(varsac_config_t, sample_sizes) == 35, "no padding");
VARSAC_ASSERT(offsetof(varsac_config_t, map) == 52, "no padding");

/* The first two are of the default search; with `method` set to VARSAC_METHOD_VARSAC the paper's looks for the same fruit. */
enum {
    VARSAC_PRESET_JUJUBE = 0,
    VARSAC_PRESET_APPLE = 1,
    VARSAC_PRESET_GENERIC = 2, /* fruit of 10 to 120 mm, by the paper's search */
    VARSAC_PRESET_TABLE5 = 3,  /* jujubes with the paper's limits as printed */
    VARSAC_PRESET_TABLE2 = 4,  /* the paper's simulation */
    VARSAC_PRESET_SURFACE = 5, /* complete surfaces of any size, measured from all around */
    VARSAC_PRESET_UNKNOWN = 6  /* one view of fruit of unknown size */
};
varsac_status_t varsac_config_preset(uint32_t preset, varsac_config_t *config);

/* Name of the first field that is out of range ("map.gate.flat"), or null. */
const char *varsac_config_problem(const varsac_config_t *config);

/* Whether to reach for a fruit, and if not, which test it failed first. The paper's search accepts all it finds. */
typedef uint32_t varsac_verdict_t;
enum {
    VARSAC_ACCEPTED = 0,
    VARSAC_REFUSED_FEW_POINTS = 1,     /* too few points explained */
    VARSAC_REFUSED_SIZE_CONFLICT = 2,  /* the points want another size than the prior allows */
    VARSAC_REFUSED_SIZE_UNKNOWN = 3,   /* the view does not tell the size */
    VARSAC_REFUSED_AMBIGUOUS = 4,      /* another fit a little aside explains nearly as much */
    VARSAC_REFUSED_OUTLINE = 5,        /* the outline does not fit */
    VARSAC_REFUSED_VISIBLE = 6,        /* too little of it is seen */
    VARSAC_REFUSED_COLOUR = 7,         /* too much of it has another colour */
    VARSAC_REFUSED_UNCERTAIN = 8,      /* the centre is too uncertain */
    VARSAC_REFUSED_FLAT = 9,           /* the points are as well a plane */
    VARSAC_REFUSED_THROUGH = 10,       /* too much is seen through it */
    VARSAC_REFUSED_SHARED_VOLUME = 11, /* it shares volume with a target found before */
    VARSAC_REFUSED_SINGULAR = 12,      /* nothing can be said: the equations are singular */
    /* Of VARSAC_METHOD_MIXTURE: */
    VARSAC_REFUSED_CLUTTER = 13,       /* the points are as well uniform clutter */
    VARSAC_REFUSED_COVERAGE = 14,      /* too little of the surface is covered */
    VARSAC_REFUSED_SHAPE = 15,         /* the body is no ellipsoid */
    VARSAC_REFUSED_VAGUE = 16          /* the centre is too uncertain for the size of the body */
};

/* A word or two for a verdict; never null. */
const char *varsac_verdict_text(varsac_verdict_t verdict);

/* One fruit. */
typedef struct varsac_detection {
    float centre_mm[3];
    float semi_axes_mm[3];     /* longest first */
    float axes[3][3];          /* row k: unit vector of semi-axis k; right-handed */
    float quaternion_xyzw[4];  /* attitude, w >= 0 */
    float sigma_centre_mm[3];  /* standard deviations of the centre's coordinates; INFINITY where not known */
    /* Covariance of centre (mm), semi-axes (mm) and rotation vector (rad, in the frame of the cloud), lower triangle by rows:
     * entry (i, j), j <= i, is number i * (i + 1) / 2 + j. Infinite variances where it is not known: always after the
     * paper's search. */
    float covariance[45];
    varsac_verdict_t verdict;
    float refusal_value;       /* what the failed test measured ... */
    float refusal_limit;       /* ... and what it allows; 0 where accepted */
    uint32_t inliers;          /* points that support it */
    uint32_t candidates;       /* points that could have */
    uint32_t trials;           /* hypotheses that were tried for it */
    uint32_t target;           /* 1, 2, ...: also the label of its points in the workspace */
} varsac_detection_t;
VARSAC_ASSERT(sizeof(varsac_detection_t) == 296, "no padding");

/* Room for what one search finds, until all of it is judged; its contents are private. */
#define VARSAC_FINDS_WORDS 800
typedef struct varsac_finds {
    uint64_t words[VARSAC_FINDS_WORDS];
} varsac_finds_t;

/* Memory of a search: 5 bytes a point, and a varsac_finds_t. Use the macro, at file scope or inside a function:
 *     VARSAC_WORKSPACE(workspace, 2048);
 * After a search, workspace_labels[i] is 0 or the number of the target that claimed point i. */
typedef struct varsac_workspace {
    uint16_t *order;
    uint16_t *members;
    uint8_t *labels;
    varsac_finds_t *finds;
    uint32_t capacity;
} varsac_workspace_t;
#define VARSAC_WORKSPACE(name, points)                                                          \
    VARSAC_ASSERT((points) > 0 && (points) <= 65535, "1 to 65535 points");                      \
    static uint16_t name##_order[(points)];                                                     \
    static uint16_t name##_members[(points)];                                                   \
    static uint8_t name##_labels[(points)];                                                     \
    static varsac_finds_t name##_finds;                                                         \
    static const varsac_workspace_t name = {name##_order, name##_members, name##_labels, &name##_finds, (points)}

/* Searches a view to the end, or until `capacity` targets are found, and writes their number to `found`. Refused targets
 * are targets too: look at `verdict`. The same view, configuration and seed give the same bits on every machine. */
varsac_status_t varsac_detect(const varsac_config_t *config, const varsac_view_t *view,
                              const varsac_workspace_t *workspace, uint64_t seed, varsac_detection_t *detections,
                              uint32_t capacity, uint32_t *found);

/* The same in bounded pieces, for a loop that must not be held up. Memory of a search; its contents are private.
 * From varsac_begin on, do not move or change search, points, outline or workspace until the search is over or given up;
 * to give it up, simply do not call varsac_step again. */
#define VARSAC_SEARCH_WORDS 320
typedef struct varsac_search {
    uint64_t words[VARSAC_SEARCH_WORDS];
} varsac_search_t;

varsac_status_t varsac_begin(varsac_search_t *search, const varsac_config_t *config, const varsac_view_t *view,
                             const varsac_workspace_t *workspace, uint64_t seed);

/* One piece of work: VARSAC_WORKING, VARSAC_FOUND (and `detection`, if not null, is filled in), VARSAC_FINISHED. */
varsac_status_t varsac_step(varsac_search_t *search, varsac_detection_t *detection);

#ifdef __cplusplus
}
#endif
#endif
