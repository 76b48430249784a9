// Reads a rope in 3-D (sent by tests/c/main.rs): without subscribing, after subscribing, and a rope
// without a position.

#include <lariat.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int wrong = 0;

#define HOLDS(claim) \
    do { \
        if (!(claim)) { \
            printf("line %d: not so: %s (%s)\n", __LINE__, #claim, lariat_error()); \
            wrong++; \
        } \
    } while (0)
#define NEAR(a, b) (fabs((a) - (b)) < 1e-12)

int main(void) {
    lariat_reader *reader;
    lariat_rope rope;
    const lariat_descriptor3 *in_space = NULL;
    double at[3];
    if (lariat_open("space", &reader) < 0 || lariat_wait(reader, 60000LL * LARIAT_MS) != 1) {
        printf("nothing came: %s\n", lariat_error());
        return 1;
    }
    HOLDS(lariat_rope_at(reader, 0, UINT64_MAX, &rope) == LARIAT_FRESH);
    HOLDS(lariat_in_space(reader, rope.track, &in_space) == LARIAT_ERROR_NO_SPACE && in_space == NULL);
    HOLDS(strstr(lariat_error(), "lariat_follow_in_space") != NULL);
    HOLDS(lariat_follow_in_space(reader) == 0);
    // Messages sent before the reader subscribed are not available.
    for (int look = 0; look < 1000 && in_space == NULL; look++) {
        HOLDS(lariat_wait(reader, 60000LL * LARIAT_MS) == 1);
        HOLDS(lariat_rope_at(reader, 0, UINT64_MAX, &rope) == LARIAT_FRESH);
        if (lariat_in_space(reader, rope.track, &in_space) < 0) HOLDS(strstr(lariat_error(), "nothing of space") != NULL);
    }
    HOLDS(in_space != NULL && in_space->track == rope.track.number && in_space->count == 2);
    HOLDS(in_space->place == LARIAT_PLACE_KNOWN && NEAR(in_space->length, 120) && NEAR(in_space->covariances[1][5], 7));
    HOLDS(lariat_point3_at(in_space, 0.25, at) == 0 && NEAR(at[0], 25) && NEAR(at[1], -10) && NEAR(at[2], 475));
    // The other rope has no position.
    HOLDS(lariat_rope_at(reader, 1, UINT64_MAX, &rope) == LARIAT_FRESH);
    HOLDS(lariat_in_space(reader, rope.track, &in_space) == LARIAT_ERROR_NO_SPACE && in_space == NULL);
    HOLDS(lariat_point3_at(in_space, 0.25, at) == LARIAT_ERROR_NULL && isnan(at[0]));
    rope.track.number = 77;
    HOLDS(lariat_in_space(reader, rope.track, &in_space) == LARIAT_ERROR_NO_ROPE && in_space == NULL);
    lariat_close(reader);
    printf("%d wrong\n", wrong);
    return wrong != 0;
}
