// A control loop with its own poll: a cycle of 2 ms, frames whenever they come, and Ctrl-C.
//
//     cc poll.c $(pkg-config --cflags --libs lariat) -o poll
//
// In each cycle, the robot moves by the rope's position at that time: the chain runs with --filter,
// so that ropes have velocities. Arguments: the rig, and the number of frames after which to end.

#define _GNU_SOURCE
#include <lariat.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/signalfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

static int beat_of(long ns) {
    struct itimerspec beat = {{0, ns}, {0, ns}};
    int timer = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    timerfd_settime(timer, 0, &beat, NULL);
    return timer;
}

static int signals(void) {
    sigset_t ends;
    sigemptyset(&ends);
    sigaddset(&ends, SIGINT);
    sigaddset(&ends, SIGTERM);
    sigprocmask(SIG_BLOCK, &ends, NULL);
    return signalfd(-1, &ends, SFD_CLOEXEC);
}

// Writes the current position of the rope's middle, if it is known.
static int middle(lariat_reader *reader, double at[2]) {
    lariat_rope rope;
    lariat_descriptor now;
    if (lariat_only_rope(reader, 100 * LARIAT_MS, &rope) != LARIAT_FRESH) return -1;
    if (lariat_predict(reader, rope.track, lariat_now_ns(), &now) == 0) return lariat_point_at(&now, 0.5, at);
    return lariat_point_at(rope.fresh, 0.5, at); // No velocities: use the position in the image.
}

int main(int count, char **arguments) {
    const char *rig = count > 1 ? arguments[1] : "default";
    long frames = count > 2 ? atol(arguments[2]) : -1;
    lariat_reader *reader;
    if (lariat_open(rig, &reader) < 0) {
        fprintf(stderr, "poll: %s\n", lariat_error());
        return 1;
    }
    struct pollfd wait[3] = {{lariat_fd(reader), POLLIN, 0}, {beat_of(2 * LARIAT_MS), POLLIN, 0}, {signals(), POLLIN, 0}};
    unsigned long beats = 0, held = 0;
    while (frames != 0 && !(wait[2].revents & POLLIN)) {
        int timeout_ms, is_new;
        if (lariat_before_poll(reader, &timeout_ms) < 0) break; // Before each sleep …
        if (poll(wait, 3, timeout_ms) < 0) continue;
        if ((is_new = lariat_latest(reader)) < 0) break; // … and after it.
        frames -= is_new;
        uint64_t passed;
        if (!(wait[1].revents & POLLIN) || read(wait[1].fd, &passed, sizeof passed) < 0) continue;
        double at[2];
        beats++;
        if (middle(reader, at) == 0)
            printf("move %.1f %.1f px/s\n", 320.0 - at[0], 240.0 - at[1]);
        else
            held++;
    }
    printf("%lu beats, held at %lu\n", beats, held);
    if (*lariat_error()) fprintf(stderr, "poll: %s\n", lariat_error());
    lariat_close(reader);
    close(wait[1].fd);
    close(wait[2].fd);
    return 0;
}
