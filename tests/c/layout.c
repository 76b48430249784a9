// Reads a message in which every number is its own offset (examples/message_of_offsets.rs), field
// by field.

#include <lariat.h>
#include <stdio.h>

static int wrong = 0;

static void is_u64(const char *name, uint64_t found, uint64_t offset) {
    if (found == offset) return;
    printf("%s: %llu is read at offset %llu\n", name, (unsigned long long)found, (unsigned long long)offset);
    wrong++;
}

static void is_double(const char *name, double found, uint64_t offset) {
    if (found == (double)offset + 0.5) return;
    printf("%s: %f is read at offset %llu\n", name, found, (unsigned long long)offset);
    wrong++;
}

#define U64(field, offset) is_u64(#field, field, offset)
#define DOUBLE(field, offset) is_double(#field, field, offset)

static void read_trace(const lariat_trace *trace) {
    U64(trace->sequence, 0);
    U64(trace->captured, 8);
    U64(trace->extracted, 16);
    U64(trace->fitted, 24);
    U64(trace->bridged, 32);
    U64(trace->exposed_ns, 40);
    U64(trace->captured_ns, 48);
    U64(trace->extract_started_ns, 56);
    U64(trace->extracted_ns, 64);
    U64(trace->fit_started_ns, 72);
    U64(trace->fitted_ns, 80);
    U64(trace->settings, 88);
    U64(trace->restarts, 92);
}

static void read_rope(const lariat_descriptor *rope, uint64_t at) {
    U64(rope->track, at);
    U64(rope->status, at + 4);
    U64(rope->basis, at + 8);
    U64(rope->degree, at + 12);
    U64(rope->count, at + 16);
    U64(rope->samples, at + 20);
    U64(rope->closed, at + 24);
    U64(rope->border, at + 28);
    DOUBLE(rope->rms, at + 32);
    DOUBLE(rope->max, at + 40);
    DOUBLE(rope->residual_variance, at + 48);
    DOUBLE(rope->condition, at + 56);
    DOUBLE(rope->length, at + 64);
    DOUBLE(rope->width, at + 72);
    U64(rope->age_ns, at + 80);
    U64(rope->hidden, at + 88);
    U64(rope->filtered, at + 92);
    U64(rope->fit, at + 96);
    DOUBLE(rope->confidence, at + 100);
    for (uint64_t j = 0; j < LARIAT_MAX_CONTROL_POINTS; j++) {
        for (uint64_t axis = 0; axis < 2; axis++) {
            DOUBLE(rope->control_points[j][axis], at + 104 + 16 * j + 8 * axis);
            DOUBLE(rope->velocities[j][axis], at + 1640 + 16 * j + 8 * axis);
        }
        for (uint64_t entry = 0; entry < 3; entry++)
            DOUBLE(rope->covariances[j][entry], at + 872 + 24 * j + 8 * entry);
        DOUBLE(rope->weights[j], at + 616 + 8 * j);
        DOUBLE(rope->knots[j], at + 2152 + 8 * j);
    }
}

static void read_points(const lariat_centerline *line, uint64_t at) {
    U64(line->count, at);
    U64(line->closed, at + 4);
    for (uint64_t word = 0; word < LARIAT_HIDDEN_WORDS; word++) U64(line->hidden[word], at + 8 + 4 * word);
    for (uint64_t i = 0; i < LARIAT_MAX_POINTS; i++) {
        for (uint64_t axis = 0; axis < 2; axis++) DOUBLE(line->points[i][axis], at + 40 + 8 * i + 4 * axis);
        DOUBLE(line->widths[i], at + 2088 + 4 * i);
    }
}

int main(void) {
    lariat_reader *reader;
    lariat_rope rope;
    double at[2] = {0, 0};
    if (lariat_open("layout", &reader) < 0 || lariat_wait(reader, 60000LL * LARIAT_MS) != 1) {
        printf("nothing came: %s\n", lariat_error());
        return 1;
    }
    const lariat_descriptors *message = lariat_message(reader);
    read_trace(&message->trace);
    U64(message->width, 96);
    U64(message->height, 100);
    U64(message->count, 104);
    U64(message->unit, 108);
    for (uint64_t i = 0; i < LARIAT_MAX_ROPES; i++) read_rope(&message->ropes[i], 112 + 2408 * i);
    for (uint64_t i = 0; i < LARIAT_MAX_ROPES; i++) read_points(&message->centerlines[i], 112 + LARIAT_MAX_ROPES * 2408 + 3112 * i);
    // These numbers are a message, but not a rope.
    if (lariat_rope_at(reader, LARIAT_MAX_ROPES - 1, UINT64_MAX, &rope) != LARIAT_UNREADABLE
        || lariat_rope_at(reader, LARIAT_MAX_ROPES, UINT64_MAX, &rope) != LARIAT_NO_ROPE
        || lariat_point_at(&message->ropes[0], 0.5, at) != LARIAT_ERROR_UNREADABLE || at[0] == at[0]) {
        printf("what is no rope was taken for one\n");
        wrong++;
    }
    if (lariat_centerline_of(reader, &message->ropes[3]) != &message->centerlines[3]) {
        printf("a rope's centerline is another's\n");
        wrong++;
    }
    lariat_close(reader);
    printf("%d wrong\n", wrong);
    return wrong != 0;
}
