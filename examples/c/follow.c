// A control loop in C: steers the middle of the rope to the middle of the image.
//
//     crates/c/install.sh --prefix ~/.local          # once: the library, the header, and how to find them
//     cc follow.c $(pkg-config --cflags --libs lariat) -o follow
//     lariat run & ./follow
//
// Instead of a robot, this example prints. Arguments: the rig, and the number of frames after which
// to end.

#include <lariat.h>
#include <stdio.h>
#include <stdlib.h>

static void move(double vx, double vy) { printf("move %.1f %.1f px/s\n", vx, vy); }
static void hold(const char *why) { printf("hold: %s\n", why); }

int main(int count, char **arguments) {
    const char *rig = count > 1 ? arguments[1] : "default";
    long frames = count > 2 ? atol(arguments[2]) : -1;

    lariat_reader *reader;
    lariat_rope rope;
    double at[2];
    int is_new = lariat_open(rig, &reader);
    while (is_new >= 0 && frames != 0) {
        is_new = lariat_wait(reader, 50 * LARIAT_MS);
        if (lariat_only_rope(reader, 100 * LARIAT_MS, &rope) == LARIAT_FRESH
            && lariat_point_at(rope.fresh, 0.5, at) == 0)
            move(320.0 - at[0], 240.0 - at[1]);
        else
            hold(lariat_seen_text(rope.seen));
        frames -= is_new > 0;
    }
    if (is_new < 0) fprintf(stderr, "follow: %s\n", lariat_error());
    lariat_close(reader);
    return is_new < 0;
}
