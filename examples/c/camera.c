// Your own camera as lariat's source: writes frames straight into shared memory, 30 times a second.
//
//     cc camera.c $(pkg-config --cflags --libs lariat) -o camera
//     lariat run --source external & ./camera
//
// Arguments: the rig, and the number of frames after which to end.

#define _POSIX_C_SOURCE 200809L
#include <lariat.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { WIDTH = 640, HEIGHT = 480 };

// Replace this with your camera: fill the rows and return the time of the exposure. Here: a dark
// rope that moves up and down on a light table.
static uint64_t grab(uint8_t *pixels, long frame) {
    memset(pixels, 220, 3 * WIDTH * HEIGHT);
    long top = 200 + labs(frame % 80 - 40);
    for (long y = top; y < top + 12; y++)
        for (long x = 80; x < 560; x++) memcpy(pixels + 3 * (y * WIDTH + x), "\x1e\x28\x78", 3);
    return lariat_now_ns();
}

int main(int count, char **arguments) {
    const char *rig = count > 1 ? arguments[1] : "default";
    long frames = count > 2 ? atol(arguments[2]) : -1;
    struct timespec period = {0, 33 * LARIAT_MS};
    int format = lariat_pixel_format("rgb8");
    lariat_writer *writer;
    uint8_t *pixels;
    if (lariat_writer_open(rig, 0, &writer) == 0) {
        for (long frame = 0; frame != frames; frame++) {
            if (lariat_writer_loan(writer, WIDTH, HEIGHT, format, &pixels) < 0) break;
            if (lariat_writer_send(writer, grab(pixels, frame), 0) < 0) break;
            nanosleep(&period, NULL);
        }
        lariat_writer_close(writer);
    }
    if (*lariat_error()) fprintf(stderr, "camera: %s\n", lariat_error());
    return *lariat_error() != 0;
}
