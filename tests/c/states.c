// Queries of invalid objects return an error and NaN, never a number or a crash. Evaluation
// functions are checked on a descriptor made here.

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

static void ask_nothing(void) {
    lariat_rope rope;
    lariat_descriptor ahead;
    lariat_track track = {1, 1, 0};
    double numbers[3];
    int timeout_ms;
    HOLDS(lariat_latest(NULL) == LARIAT_ERROR_NULL);
    HOLDS(strstr(lariat_error(), "NULL") != NULL);
    HOLDS(lariat_wait(NULL, 0) == LARIAT_ERROR_NULL);
    HOLDS(lariat_fd(NULL) == LARIAT_ERROR_NULL);
    HOLDS(lariat_before_poll(NULL, &timeout_ms) == LARIAT_ERROR_NULL);
    HOLDS(lariat_open(NULL, NULL) == LARIAT_ERROR_NULL);
    HOLDS(lariat_only_rope(NULL, 0, &rope) == LARIAT_NO_READER && rope.fresh == NULL);
    HOLDS(lariat_only_rope(NULL, 0, NULL) == LARIAT_NO_READER);
    HOLDS(lariat_predict(NULL, track, 0, &ahead) == LARIAT_ERROR_NULL && ahead.count == 0);
    HOLDS(lariat_point_at(rope.fresh, 0.5, numbers) == LARIAT_ERROR_NULL && isnan(numbers[0]) && isnan(numbers[1]));
    HOLDS(lariat_point_at(NULL, 0.5, NULL) == LARIAT_ERROR_NULL);
    const lariat_descriptor3 *in_space = (const lariat_descriptor3 *)&rope;
    HOLDS(lariat_in_space(NULL, track, &in_space) == LARIAT_ERROR_NULL && in_space == NULL);
    HOLDS(lariat_in_space(NULL, track, NULL) == LARIAT_ERROR_NULL && lariat_follow_in_space(NULL) == LARIAT_ERROR_NULL);
    HOLDS(lariat_message(NULL) == NULL && lariat_age_ns(NULL) == UINT64_MAX && lariat_run(NULL) == 0);
    HOLDS(strstr(lariat_seen_text(LARIAT_UNSURE), "centerline") != NULL && strlen(lariat_seen_text(99)) > 0);
    lariat_close(NULL);
}

static void ask_before_the_chain_runs(void) {
    lariat_reader *reader = (lariat_reader *)&wrong;
    lariat_rope rope;
    int timeout_ms = 7;
    HOLDS(lariat_open("no such name", &reader) == LARIAT_ERROR_NAME && reader == NULL);
    HOLDS(strstr(lariat_error(), "--rig") != NULL);
    HOLDS(lariat_open("quiet", &reader) == 0);
    HOLDS(lariat_latest(reader) == 0 && lariat_wait(reader, LARIAT_MS) == 0);
    HOLDS(lariat_only_rope(reader, UINT64_MAX, &rope) == LARIAT_NOTHING_YET && rope.seen == LARIAT_NOTHING_YET);
    HOLDS(rope.fresh == NULL && rope.partial == NULL && rope.unsure == NULL && rope.last_known == NULL && rope.age_ns == UINT64_MAX);
    HOLDS(lariat_message(reader) == NULL && lariat_run(reader) == 0);
    HOLDS(lariat_fd(reader) >= 0);
    HOLDS(lariat_before_poll(reader, &timeout_ms) == 0 && timeout_ms >= -1 && timeout_ms <= 100);
    HOLDS(lariat_centerline_of(reader, rope.fresh) == NULL);
    HOLDS(lariat_accept_coarse(reader, 1) == 0 && lariat_accept_coarse(NULL, 1) == LARIAT_ERROR_NULL);
    HOLDS(lariat_min_confidence(reader, 0.9f) == 0 && lariat_min_confidence(NULL, 0.9f) == LARIAT_ERROR_NULL);
    HOLDS(lariat_look_for(reader, 0) == 0 && lariat_expect_motion(reader, 500, 0.1) == 0);
    lariat_close(reader);
}

static void ask_a_curve(void) {
    // The parabola (100 ρ, 100 ρ (1 − ρ)): three Bezier points, each of variance 1 according to the
    // message.
    static lariat_descriptor rope;
    double a[2], matrix[36], shares[3], points[2 * 5], covariance[3], nearest[4];
    rope.basis = LARIAT_BASIS_BEZIER;
    rope.degree = 2;
    rope.count = 3;
    rope.samples = 120;
    rope.control_points[1][0] = 50;
    rope.control_points[1][1] = 50;
    rope.control_points[2][0] = 100;
    for (int j = 0; j < 3; j++) rope.covariances[j][0] = rope.covariances[j][2] = 1;
    HOLDS(lariat_point_at(&rope, 0.5, a) == 0 && NEAR(a[0], 50) && NEAR(a[1], 25));
    HOLDS(lariat_derivative_at(&rope, 0, a) == 0 && NEAR(a[0], 100) && NEAR(a[1], 100));
    HOLDS(lariat_tangent_at(&rope, 0.5, a) == 0 && NEAR(a[0], 1) && NEAR(a[1], 0));
    HOLDS(lariat_normal_at(&rope, 0.5, a) == 0 && NEAR(a[0], 0) && NEAR(a[1], 1));
    HOLDS(lariat_curvature_at(&rope, 0.5, a) == 0 && NEAR(a[0], -0.02));
    HOLDS(lariat_jacobian_at(&rope, 0.5, shares) == 0 && NEAR(shares[0], 0.25) && NEAR(shares[1], 0.5));
    HOLDS(lariat_points(&rope, 5, points) == 0 && NEAR(points[2], 25) && NEAR(points[8], 100) && NEAR(points[9], 0));
    HOLDS(lariat_nearest(&rope, 50, 35, nearest) == 0 && NEAR(nearest[0], 0.5) && NEAR(nearest[3], 10));
    HOLDS(NEAR(nearest[1], 50) && NEAR(nearest[2], 25));
    HOLDS(lariat_nearest(NULL, 50, 35, nearest) == LARIAT_ERROR_NULL && isnan(nearest[3]));
    HOLDS(lariat_covariance_at(&rope, 0, covariance) == 0 && NEAR(covariance[0], 1) && NEAR(covariance[1], 0));
    // The fit's outer control points are more certain than the one between them, so this covariance
    // is not the fit's.
    HOLDS(lariat_covariance(&rope, matrix) == 0 && NEAR(matrix[0], 1) && NEAR(matrix[35], 1) && NEAR(matrix[1], 0));
    rope.control_points[1][0] = rope.control_points[1][1] = rope.control_points[2][0] = 0;
    HOLDS(lariat_tangent_at(&rope, 0.5, a) == LARIAT_ERROR_NO_DIRECTION && isnan(a[0]));
    rope.basis = LARIAT_BASIS_POINTS;
    HOLDS(lariat_point_at(&rope, 0.5, a) == LARIAT_ERROR_NO_CURVE && isnan(a[0]));
}

static void ask_a_curve_in_space(void) {
    // The parabola (100 ρ, 100 ρ (1 − ρ), 500), in mm.
    static lariat_descriptor3 rope;
    double a[3], shares[3], points[3 * 5], nearest[5];
    rope.place = LARIAT_PLACE_KNOWN;
    rope.basis = LARIAT_BASIS_BEZIER;
    rope.degree = 2;
    rope.count = 3;
    rope.samples = 120;
    rope.control_points[1][0] = rope.control_points[1][1] = 50;
    rope.control_points[2][0] = 100;
    for (int j = 0; j < 3; j++) rope.control_points[j][2] = 500;
    HOLDS(lariat_point3_at(&rope, 0.5, a) == 0 && NEAR(a[0], 50) && NEAR(a[1], 25) && NEAR(a[2], 500));
    HOLDS(lariat_derivative3_at(&rope, 0, a) == 0 && NEAR(a[0], 100) && NEAR(a[1], 100) && NEAR(a[2], 0));
    HOLDS(lariat_tangent3_at(&rope, 0.5, a) == 0 && NEAR(a[0], 1) && NEAR(a[1], 0) && NEAR(a[2], 0));
    HOLDS(lariat_curvature3_at(&rope, 0.5, a) == 0 && NEAR(a[0], 0.02));
    HOLDS(lariat_jacobian3_at(&rope, 0.5, shares) == 0 && NEAR(shares[0], 0.25) && NEAR(shares[1], 0.5));
    HOLDS(lariat_points3(&rope, 5, points) == 0 && NEAR(points[3], 25) && NEAR(points[12], 100) && NEAR(points[14], 500));
    HOLDS(lariat_nearest3(&rope, 50, 25, 490, nearest) == 0 && NEAR(nearest[0], 0.5) && NEAR(nearest[4], 10));
    HOLDS(NEAR(nearest[1], 50) && NEAR(nearest[2], 25) && NEAR(nearest[3], 500));
    HOLDS(lariat_nearest3(NULL, 50, 25, 490, nearest) == LARIAT_ERROR_NULL && isnan(nearest[4]));
    rope.place = LARIAT_PLACE_THIN;
    HOLDS(lariat_point3_at(&rope, 0.5, a) == LARIAT_ERROR_NO_SPACE && isnan(a[0]) && isnan(a[2]));
    rope.place = 99;
    HOLDS(lariat_point3_at(&rope, 0.5, a) == LARIAT_ERROR_UNREADABLE && isnan(a[0]));
}

static void ask_a_centerline(void) {
    // Right, then down: three points, 50 apart.
    static lariat_centerline line;
    double a[4];
    line.count = 3;
    line.points[1][0] = line.points[2][0] = line.points[2][1] = 50;
    HOLDS(lariat_centerline_point_at(&line, 0.75, a) == 0 && NEAR(a[0], 50) && NEAR(a[1], 25));
    HOLDS(lariat_centerline_nearest(&line, 60, 25, a) == 0 && NEAR(a[0], 0.75) && NEAR(a[3], 10));
    HOLDS(NEAR(a[1], 50) && NEAR(a[2], 25));
    line.closed = 1;
    HOLDS(lariat_centerline_point_at(&line, 5.0 / 6, a) == 0 && NEAR(a[0], 25) && NEAR(a[1], 25));
    line.count = 0;
    HOLDS(lariat_centerline_nearest(&line, 0, 0, a) == LARIAT_ERROR_UNREADABLE && isnan(a[0]) && isnan(a[3]));
    HOLDS(lariat_centerline_point_at(NULL, 0, a) == LARIAT_ERROR_NULL && isnan(a[0]));
    HOLDS(lariat_centerline_of(NULL, NULL) == NULL);
}

static void write_frames(void) {
    lariat_writer *writer = (lariat_writer *)1, *other;
    uint8_t *pixels = (uint8_t *)1;
    HOLDS(lariat_writer_open(NULL, 0, &writer) == LARIAT_ERROR_NULL && writer == NULL);
    HOLDS(lariat_writer_open("default", 0, NULL) == LARIAT_ERROR_NULL);
    HOLDS(lariat_writer_open("no such name", 0, &writer) == LARIAT_ERROR_NAME && writer == NULL);
    HOLDS(lariat_writer_loan(NULL, 4, 4, 1, &pixels) == LARIAT_ERROR_NULL && pixels == NULL);
    HOLDS(lariat_writer_send(NULL, 0, 0) == LARIAT_ERROR_NULL && lariat_writer_send_blank(NULL) == LARIAT_ERROR_NULL);
    lariat_writer_stop(NULL);
    lariat_writer_close(NULL);
    HOLDS(lariat_pixel_format(NULL) == LARIAT_ERROR_NULL && lariat_pixel_format("rgb") == LARIAT_ERROR_IMAGE);
    HOLDS(lariat_pixel_format("gray8") == 1 && lariat_pixel_format("nv12") == 5);

    HOLDS(lariat_writer_open("default", 0, &writer) == 0);
    HOLDS(lariat_writer_open("default", 0, &other) == LARIAT_ERROR_TAKEN && other == NULL);
    HOLDS(strstr(lariat_error(), "--source external") != NULL);
    HOLDS(lariat_writer_send(writer, 0, 0) == LARIAT_ERROR_IMAGE);
    HOLDS(lariat_writer_loan(writer, 4, 4, 1, NULL) == LARIAT_ERROR_NULL);
    HOLDS(lariat_writer_loan(writer, 0, 4, 1, &pixels) == LARIAT_ERROR_IMAGE && pixels == NULL);
    HOLDS(lariat_writer_loan(writer, 4, 4, 99, &pixels) == LARIAT_ERROR_IMAGE);
    for (uint32_t side = 4; side <= 400; side *= 10) {
        HOLDS(lariat_writer_loan(writer, side, side, 2, &pixels) == 0);
        memset(pixels, 7, 3 * side * side);
        HOLDS(lariat_writer_send(writer, lariat_now_ns(), side) == 0);
    }
    HOLDS(lariat_writer_loan(writer, 4, 4, 1, &pixels) == 0);
    HOLDS(lariat_writer_send(writer, lariat_now_ns() + 60 * 1000ull * LARIAT_MS, 0) == LARIAT_ERROR_IMAGE);
    HOLDS(lariat_writer_send_blank(writer) == 0);
    lariat_writer_stop(writer);
    lariat_writer_close(writer);
    HOLDS(lariat_writer_open("default", LARIAT_LOSSLESS, &writer) == 0);
    lariat_writer_close(writer);
}

int main(void) {
    HOLDS(lariat_abi() == LARIAT_ABI);
    HOLDS(strlen(lariat_version()) >= 5);
    HOLDS(strlen(lariat_error()) == 0);
    ask_nothing();
    ask_before_the_chain_runs();
    ask_a_curve();
    ask_a_curve_in_space();
    ask_a_centerline();
    write_frames();
    printf("%d wrong\n", wrong);
    return wrong != 0;
}
