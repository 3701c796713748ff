/* Flies an actor through covey.h and prints what comes out, one value a line; the Rust test beside it knows what must.
 * Usage: flight ACTOR_FILE */
#include "covey.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NUMBER(what) printf(#what " %ld\n", (long)(what))
#define FIELD(type, field) printf(#type "." #field " %zu\n", offsetof(type, field))

static void layout(void) {
    NUMBER(sizeof(covey_actor));
    NUMBER(sizeof(covey_vec2));
    NUMBER(sizeof(covey_neighbour));
    FIELD(covey_neighbour, velocity);
    FIELD(covey_neighbour, id);
    FIELD(covey_neighbour, tie);
    NUMBER(sizeof(covey_scene));
    FIELD(covey_scene, velocity);
    FIELD(covey_scene, half_side);
    FIELD(covey_scene, id);
    FIELD(covey_scene, tie);
    FIELD(covey_scene, neighbours);
    FIELD(covey_scene, neighbour_count);
    FIELD(covey_scene, pois);
    FIELD(covey_scene, poi_count);
    NUMBER(sizeof(covey_view));
    FIELD(covey_view, degree);
    FIELD(covey_view, kept);
    NUMBER(sizeof(covey_feature));
    FIELD(covey_feature, attending);
    FIELD(covey_feature, attended);
    FIELD(covey_feature, own);
    NUMBER(sizeof(covey_neighbour_feature));
    FIELD(covey_neighbour_feature, degree);
    FIELD(covey_neighbour_feature, attended);
    NUMBER(sizeof(covey_decision));
    FIELD(covey_decision, action);
    NUMBER(sizeof(covey_map));
    FIELD(covey_map, unit_m);
    FIELD(covey_map, step_ms);
    NUMBER(COVEY_OBSERVATION);
    NUMBER(COVEY_FEATURE);
    NUMBER(COVEY_NEIGHBOURS);
    NUMBER(COVEY_ACTIONS);
    NUMBER(COVEY_TICKS_PER_U);
    NUMBER(COVEY_OK);
    NUMBER(COVEY_TRUNCATED);
    NUMBER(COVEY_EXTENDED);
    NUMBER(COVEY_NOT_AN_ACTOR);
    NUMBER(COVEY_VERSION);
    NUMBER(COVEY_CHECKSUM);
    NUMBER(COVEY_MALFORMED);
    NUMBER(COVEY_OBSERVATION_FORM);
    NUMBER(COVEY_DIMENSION);
    NUMBER(COVEY_LENGTH);
    NUMBER(COVEY_OUT_OF_RANGE);
    NUMBER(COVEY_SELF_TESTS);
    NUMBER(COVEY_CONTENT_HASH);
    NUMBER(COVEY_LOAD_FAILED);
    NUMBER(COVEY_NULL);
    NUMBER(COVEY_NOT_LOADED);
    NUMBER(COVEY_NOT_TESTED);
    NUMBER(COVEY_SELF_TEST_FAILED);
    NUMBER(COVEY_ARGUMENT);
    NUMBER(COVEY_SAMPLE);
    NUMBER(COVEY_ARGMAX);
}

static void navigation(void) {
    covey_map map = {473977418, 85455939, 2.5, 2000};
    covey_vec2 position = {0, 0}, velocity = {0, 0};
    int32_t lat = 0, lon = 0;
    for (int i = 0; i < 5; i++) {
        NUMBER(covey_map_position(&map, map.lat_e7 + 9001 * i, map.lon_e7 - 12345 * i, &position));
        printf("position %ld %ld\n", (long)position.x, (long)position.y);
        NUMBER(covey_map_degrees(&map, position, &lat, &lon));
        printf("degrees %ld %ld\n", (long)lat, (long)lon);
        NUMBER(covey_map_velocity(&map, 1.25f * (float)i, -0.7f, &velocity));
        printf("velocity %ld %ld\n", (long)velocity.x, (long)velocity.y);
        float heading = covey_heading_rad((float)(i - 2), 0.75f);
        uint32_t bits;
        memcpy(&bits, &heading, sizeof bits);
        printf("heading %08" PRIx32 " %ld\n", bits, (long)covey_heading_cdeg((float)(i - 2), 0.75f));
    }
    NUMBER(covey_heading_cdeg(0, 0));
    NUMBER(covey_heading_rad(0, 0));
    NUMBER(covey_map_position(&map, 0, 0, &position));
    NUMBER(covey_map_position(NULL, 0, 0, &position));
    NUMBER(covey_map_degrees(&map, position, &lat, NULL));
    map.unit_m = 0;
    NUMBER(covey_map_degrees(&map, position, &lat, &lon));
    NUMBER(covey_map_velocity(&map, 1, 1, &velocity));
}

static uint8_t file[1 << 17];

int main(int argc, char **argv) {
    static covey_actor actor;
    FILE *in = argc == 2 ? fopen(argv[1], "rb") : NULL;
    if (in == NULL) {
        fputs("usage: flight ACTOR_FILE\n", stderr);
        return EXIT_FAILURE;
    }
    size_t length = fread(file, 1, sizeof file, in);
    fclose(in);
    layout();
    navigation();

    /* Every way to be early. */
    covey_view view;
    covey_feature own;
    covey_decision decision;
    NUMBER(covey_self_test(&actor));
    NUMBER(covey_content_hash(&actor) == 0);
    NUMBER(covey_load(&actor, file, length - 1));
    NUMBER(covey_encode(&actor, view.observation, &own));
    NUMBER(covey_load(&actor, file, length));
    NUMBER(covey_encode(&actor, view.observation, &own));
    NUMBER(covey_decide(&actor, &own, 1, NULL, 0, COVEY_SAMPLE, 1, 2, 3, &decision));
    NUMBER(covey_self_test(&actor));
    NUMBER(covey_load(NULL, file, length));
    NUMBER(covey_encode(&actor, NULL, &own));

    printf("content hash %016" PRIx64 "\n", covey_content_hash(&actor));
    printf("message hash %08" PRIx32 "\n", covey_message_hash(&actor));
    printf("signature %016" PRIx64 "\n", covey_signature(&actor, 100));
    NUMBER(covey_feature_width(&actor));
    NUMBER(covey_tie_breaker(&actor, 10, 7, 5));

    /* One step: 20 others on a line, one of them with the own id; 30 points. */
    covey_neighbour others[20];
    covey_vec2 pois[30];
    for (int i = 0; i < 20; i++) {
        covey_neighbour n = {{102400 + 900 * i, 102400 - 300 * i}, {10 * i, -20 * i}, (uint16_t)(100 + i), (int8_t)(3 * i - 30)};
        others[i] = n;
    }
    others[4].id = 7;
    for (int i = 0; i < 30; i++) {
        covey_vec2 p = {102400 - 700 * i, 102400 + 100 * i};
        pois[i] = p;
    }
    covey_scene scene = {{102400, 102400}, {2048, -1024}, 102400, 7, covey_tie_breaker(&actor, 10, 7, 5), others, 20, pois, 30};
    NUMBER(covey_observe(&scene, &view));
    printf("observation");
    for (int i = 0; i < COVEY_OBSERVATION; i++) printf(" %d", view.observation[i]);
    printf("\ndegree %d kept", view.degree);
    for (int i = 0; i < COVEY_NEIGHBOURS; i++) printf(" %d", view.kept[i]);
    printf("\n");
    NUMBER(covey_encode(&actor, view.observation, &own));
    printf("feature");
    for (int i = 0; i < COVEY_FEATURE; i++) printf(" %d", own.values[i]);
    printf(" %d %d\n", own.attending, own.attended);
    printf("own");
    for (int i = 0; i < COVEY_FEATURE; i++) printf(" %d", own.own[i]);
    printf("\n");

    int8_t values[COVEY_NEIGHBOURS][COVEY_FEATURE];
    covey_neighbour_feature features[COVEY_NEIGHBOURS + 1];
    int count = view.degree - 1;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < COVEY_FEATURE; k++) values[i][k] = (int8_t)((7 * i + 5 * k) % 128);
        covey_neighbour_feature f = {values[i], (uint8_t)(1 + i), (int16_t)(40 * i - 300)};
        features[i] = f;
    }
    for (int mode = COVEY_SAMPLE; mode <= COVEY_ARGMAX; mode++) {
        NUMBER(covey_decide(&actor, &own, view.degree, features, (size_t)count, mode, 10, 7, 5, &decision));
        printf("action %d logits", decision.action);
        for (int i = 0; i < COVEY_ACTIONS; i++) printf(" %d", decision.logits[i]);
        printf("\n");
    }
    NUMBER(covey_decide(&actor, &own, 1, NULL, 0, COVEY_ARGMAX, 10, 7, 5, &decision));
    printf("alone %d\n", decision.action);

    /* Every way to ask wrongly. */
    NUMBER(covey_decide(&actor, &own, 0, NULL, 0, COVEY_ARGMAX, 10, 7, 5, &decision));
    NUMBER(covey_decide(&actor, &own, 18, NULL, 0, COVEY_ARGMAX, 10, 7, 5, &decision));
    NUMBER(covey_decide(&actor, &own, 1, NULL, 0, 2, 10, 7, 5, &decision));
    NUMBER(covey_decide(&actor, &own, 1, NULL, 1, COVEY_ARGMAX, 10, 7, 5, &decision));
    NUMBER(covey_decide(&actor, &own, 1, features, 17, COVEY_ARGMAX, 10, 7, 5, &decision));
    NUMBER(covey_decide(&actor, &own, 1, features, 1, COVEY_ARGMAX, 10, 7, 5, &decision));
    features[0].degree = 0;
    NUMBER(covey_decide(&actor, &own, 2, features, 1, COVEY_ARGMAX, 10, 7, 5, &decision));
    features[0].values = NULL;
    NUMBER(covey_decide(&actor, &own, 2, features, 1, COVEY_ARGMAX, 10, 7, 5, &decision));
    scene.pois = NULL;
    NUMBER(covey_observe(&scene, &view));
    NUMBER(covey_observe(NULL, &view));
    printf("%s; %s\n", covey_status_text(COVEY_SELF_TEST_FAILED), covey_status_text(-1));
    return EXIT_SUCCESS;
}
