# Code for the virtual machine: functions for the rows, which `run` appends. The shell is busybox's.
# Each row prints its output between `@@row NAME` and `@@done`; `run` judges it.

export LC_ALL=C
control() { v4l2-ctl -d "${camera:-/dev/video0}" -c "$1"; }

# Sorted pids of all of lariat's processes; if they change later, one has died.
pids() { pidof lariat | tr ' ' '\n' | sort -n | tr '\n' ' '; }

# Resident memory (kB) and open file descriptors of each of lariat's processes.
usage() {
    for pid in $(pids); do
        echo "@@usage $1 $pid $(tr '\0' ' ' </proc/$pid/cmdline | cut -d ' ' -f 2) \
$(sed -n 's/^VmRSS:[^0-9]*\([0-9]*\).*/\1/p' /proc/$pid/status) $(ls /proc/$pid/fd | wc -l)"
    done
}

# Runs the whole chain with these flags, and prints its summary.
chain() {
    rm -rf out
    timeout -s KILL "${limit:-60}" lariat run --out out --duration "${seconds:-10}s" "$@" 2>&1
    echo "@@status $?"
    echo "@@summary $(tr -d '\n' <out/summary.json)"
}

# Runs the whole chain, with a fault some seconds after it is up: `faulted SECONDS COMMAND FLAGS…`.
faulted() {
    delay=$1 command=$2
    shift 2
    (
        for second in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15; do
            [ "$(pids | wc -w)" = 5 ] && break
            sleep 1
        done
        sleep "$delay"
        echo "@@before $(pids)"
        eval "$command" 2>&1
        sleep "${patience:-3}"
        echo "@@after $(pids)"
    ) &
    chain "$@"
    wait
}

# Writes the calibrations of a camera and of the depth camera 15 mm to its right, both of this size.
calibrate() {
    for name in camera depth; do
        cat >$name.yaml <<END
image_width: $1
image_height: $2
camera_matrix: [$(($1 * 72 / 100)), 0, $(($1 / 2 - 1)).5, 0, $(($1 * 72 / 100)), $(($2 / 2 - 1)).5, 0, 0, 1]
distortion_coefficients: [0, 0, 0, 0]
END
    done
    cat >>depth.yaml <<END
rotation: [0, 0, 0, 1]
translation_mm: [-15, 0, 0]
noise_mm_at_1m: 3.6
range_mm: [200, 1500]
END
}

# Takes one picture and prints a line with its checksum, which is equal for equal pictures.
picture() {
    name=$1
    shift
    timeout -s KILL 60 lariat snapshot --force --after "${after:-200ms}" "$name.png" "$@" 2>&1
    echo "@@status $?"
    echo "@@picture $name $(md5sum <"$name.png")"
}

# Test patterns of the camera: black lines of ten pixels on white, which lariat treats as ropes; or
# still bars in all colors.
ropes() { control test_pattern=19; control osd_text_mode=2; control contrast=128; control brightness=128; }
bars() { control test_pattern=0; control osd_text_mode=2; control gain_automatic=0; }

row() {
    echo "@@row $1"
    shift
    for camera in /dev/video0 /dev/video1; do
        ropes >/dev/null 2>&1
    done
    camera=/dev/video0
    "$@"
    echo "@@done"
    # Settings of a row must not affect the next one.
    for name in percentage_of_dropped_buffers wrap_sequence_number wrap_timestamp timestamp_source; do
        control $name=0 >/dev/null 2>&1
    done
}
