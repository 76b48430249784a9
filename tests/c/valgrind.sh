#!/bin/sh
# Runs a program under valgrind, and fails on any finding: invalid accesses, uninitialized values,
# leaked memory or file descriptors.
#
#     tests/c/valgrind.sh build/follow default 20
set -eu
exec valgrind --quiet --error-exitcode=99 --suppressions="$(dirname "$0")/valgrind.supp" \
    --leak-check=full --show-leak-kinds=definite,indirect,possible \
    --errors-for-leak-kinds=definite,indirect,possible --track-origins=yes "$@"
