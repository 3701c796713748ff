/* Covey's actor for C and C++ flight software.
 *
 * Nothing here allocates, blocks, keeps state of its own or calls back. Functions may be called from several threads as long as nobody
 * writes an object that another uses. Every function checks for NULL; other pointers must be valid for what they point to.
 *
 * A UAV's step: covey_observe -> covey_encode -> broadcast the feature, collect the neighbours' -> covey_decide.
 *
 * Positions are ticks of 1/1024 map unit (u), velocities ticks per step; x points east, y north. */
#ifndef COVEY_H
#define COVEY_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define COVEY_OBSERVATION 160    /* numbers in an observation */
#define COVEY_FEATURE 64         /* greatest width of a feature */
#define COVEY_NEIGHBOURS 16      /* neighbours a UAV keeps */
#define COVEY_ACTIONS 17         /* actions: 0-7 strong, 8-15 gentle acceleration, 16 coasts */
#define COVEY_TICKS_PER_U 1024   /* ticks in a map unit */

/* What a function returns. */
enum {
    COVEY_OK = 0,
    COVEY_TRUNCATED = 1,         /* the file is cut short */
    COVEY_EXTENDED = 2,          /* bytes follow the file */
    COVEY_NOT_AN_ACTOR = 3,      /* this is no actor file */
    COVEY_VERSION = 4,           /* the file is of another format version */
    COVEY_CHECKSUM = 5,          /* the file is damaged */
    COVEY_MALFORMED = 6,         /* the file's record cannot be read */
    COVEY_OBSERVATION_FORM = 7,  /* the actor wants another form of observation */
    COVEY_DIMENSION = 8,         /* widths that this library cannot fly */
    COVEY_LENGTH = 9,            /* weights that do not fit the widths */
    COVEY_OUT_OF_RANGE = 10,     /* a bias or multiplier out of bounds */
    COVEY_SELF_TESTS = 11,       /* self-test vectors that cannot be read */
    COVEY_CONTENT_HASH = 12,     /* a content hash that does not fit the content */
    COVEY_LOAD_FAILED = 13,      /* loading failed for another reason */
    COVEY_NULL = 32,             /* a pointer is NULL */
    COVEY_NOT_LOADED = 33,       /* no actor was loaded into this covey_actor */
    COVEY_NOT_TESTED = 34,       /* the self-test did not run or did not pass */
    COVEY_SELF_TEST_FAILED = 35, /* other logits than at export: do not fly */
    COVEY_ARGUMENT = 36          /* a degree, count, width or mode out of range */
};

/* How covey_decide chooses. */
enum {
    COVEY_SAMPLE = 0,            /* in proportion to the softmax of the logits */
    COVEY_ARGMAX = 1             /* the greatest logit */
};

/* A loaded actor. It refers to the file, which must stay in place (in flash, say) as long as the actor is used.
 * Make it static, set it to zeros or load it before anything else reads it. */
typedef struct covey_actor {
    uint64_t opaque[8 + 8 * sizeof(void *)];
} covey_actor;

/* A position or a velocity. */
typedef struct covey_vec2 {
    int32_t x;
    int32_t y;
} covey_vec2;

/* A neighbour, where it is at the step. */
typedef struct covey_neighbour {
    covey_vec2 position;
    covey_vec2 velocity;
    uint16_t id;
    int8_t tie;                  /* its tie-breaker */
} covey_neighbour;

/* What a UAV knows at a step. */
typedef struct covey_scene {
    covey_vec2 position;         /* own, measured */
    covey_vec2 velocity;
    int32_t half_side;           /* half the side of the map; its corner is the origin */
    uint16_t id;                 /* own */
    int8_t tie;                  /* own, from covey_tie_breaker */
    const covey_neighbour *neighbours; /* any number, in any order; the nearest in range are kept */
    size_t neighbour_count;
    const covey_vec2 *pois;      /* points of interest known, any number, in any order; those out of view do not matter */
    size_t poi_count;
} covey_scene;

/* What it sees of it. */
typedef struct covey_view {
    int8_t observation[COVEY_OBSERVATION];
    uint8_t degree;              /* neighbours kept, plus one for itself */
    uint16_t kept[COVEY_NEIGHBOURS]; /* ids of the degree - 1 neighbours kept, nearest first: their features count */
} covey_view;

/* A UAV's own feature. */
typedef struct covey_feature {
    int8_t values[COVEY_FEATURE]; /* the first covey_feature_width are used; broadcast those */
    int16_t attending;           /* stays at home */
    int16_t attended;            /* broadcast this */
    int8_t own[COVEY_FEATURE];   /* stays at home */
} covey_feature;

/* A neighbour's feature as it was received. */
typedef struct covey_neighbour_feature {
    const int8_t *values;        /* covey_feature_width of them */
    uint8_t degree;              /* the sender's, 1 to 17 */
    int16_t attended;
} covey_neighbour_feature;

/* A decision. */
typedef struct covey_decision {
    int16_t logits[COVEY_ACTIONS];
    uint8_t action;
} covey_decision;

/* Reads an actor file of `length` bytes in place. Run covey_self_test next. Returns COVEY_OK or one of 1 to 32. */
int32_t covey_load(covey_actor *actor, const uint8_t *file, size_t length);

/* Recomputes the file's self-test vectors; an actor that has not passed neither encodes nor decides. */
int32_t covey_self_test(covey_actor *actor);

/* Content hash of the actor's file; 0 when none is loaded. */
uint64_t covey_content_hash(const covey_actor *actor);

/* The part of the content hash that feature messages carry; 0 when none is loaded. */
uint32_t covey_message_hash(const covey_actor *actor);

/* Width of the features; 0 when none is loaded. */
uint8_t covey_feature_width(const covey_actor *actor);

/* One number that says "still the same function", over the first `cases` of a fixed series of neighbourhoods (10,000 by convention);
 * 0 when none is loaded. It takes `cases` times as long as a decision. */
uint64_t covey_signature(const covey_actor *actor, uint32_t cases);

/* The tie-breaker that UAV `id` announces for `step`; 0 when none is loaded. */
int8_t covey_tie_breaker(const covey_actor *actor, uint64_t seed, uint16_t id, uint32_t step);

/* Builds the observation of a scene. */
int32_t covey_observe(const covey_scene *scene, covey_view *view);

/* Encodes an observation. */
int32_t covey_encode(const covey_actor *actor, const int8_t *observation, covey_feature *feature);

/* Decides from the own feature and degree and the features of up to COVEY_NEIGHBOURS neighbours, in the order of covey_view.kept;
 * fewer than `degree`, which counts the UAV itself.
 * `neighbours` may be NULL when `count` is 0. Seed, id and step draw the action when `mode` is COVEY_SAMPLE. */
int32_t covey_decide(const covey_actor *actor, const covey_feature *own, uint8_t degree,
                     const covey_neighbour_feature *neighbours, size_t count,
                     int32_t mode, uint64_t seed, uint16_t id, uint32_t step,
                     covey_decision *decision);

/* The map in flight, the same on every UAV of the swarm. */
typedef struct covey_map {
    int32_t lat_e7;              /* its south-west corner, 1e-7 degrees, as in GLOBAL_POSITION_INT: within 80 degrees north and south, */
    int32_t lon_e7;              /* at most 180 degrees east or west */
    double unit_m;               /* metres in a map unit */
    uint16_t step_ms;            /* milliseconds in a step */
} covey_map;

/* The position on the map of a latitude and longitude in 1e-7 degrees, for covey_scene; COVEY_ARGUMENT for a map that cannot be, or a
 * place more than 20 km from its corner. The earth is taken as flat around the corner, with ArduPilot's metres per degree. */
int32_t covey_map_position(const covey_map *map, int32_t lat_e7, int32_t lon_e7, covey_vec2 *position);

/* Latitude and longitude (1e-7 degrees, to the nearest) of a position on the map. */
int32_t covey_map_degrees(const covey_map *map, covey_vec2 position, int32_t *lat_e7, int32_t *lon_e7);

/* A velocity in m/s as ticks per step, for covey_scene; COVEY_ARGUMENT for a map that cannot be, or numbers that are not finite. */
int32_t covey_map_velocity(const covey_map *map, float east_mps, float north_mps, covey_vec2 *velocity);

/* Where a velocity or setpoint points: radians clockwise from north, 0 to 2 pi, within 0.0029 of the exact angle; -1 for a vector without
 * length, or not finite: keep the heading then. The unit does not matter. */
float covey_heading_rad(float east, float north);

/* The same in hundredths of a degree, 0 to 35999, as MAVLink's hdg; -1 when there is none. */
int32_t covey_heading_cdeg(float east, float north);

/* What a status means, in English. Never NULL. */
const char *covey_status_text(int32_t status);

#ifdef __cplusplus
}
#endif

#endif
