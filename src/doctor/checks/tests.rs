use super::*;

const USER: &str = "Name:\tlariat\nCapEff:\t0000000000000000\n";
const ROOT: &str = "Name:\tlariat\nCapEff:\t000001ffffffffff\n";

fn limits(rtprio: &str, memlock: &str) -> String {
    format!(
        "Limit                     Soft Limit           Hard Limit           Units     \n\
         Max locked memory         {memlock}            {memlock}            bytes     \n\
         Max realtime priority     {rtprio}             {rtprio}                       \n"
    )
}

#[test]
fn only_what_keeps_lariat_from_working_is_bad() {
    let bad = [
        shared_memory(None),
        shared_memory(Some((64 << 20, 4 << 20))),
        domain(Some("permission denied".to_owned())),
    ];
    assert!(bad.iter().all(|found| found.verdict == Verdict::Bad));
    // The worst of all else.
    let worst = [
        shared_memory(Some((64 << 20, 60 << 20))),
        cores(1),
        realtime_priority(&limits("0", "65536"), USER),
        locked_memory(&limits("0", "65536"), USER),
        realtime_share("-1\n"),
        realtime_share("0\n"),
        preemption("Linux version 6.1 #1 SMP", "", ""),
        governor(&["powersave\n".to_owned(), "performance\n".to_owned()]),
        idle_states(&[["C6\n", "133\n", "0\n"].map(str::to_owned)]),
        isolated_cores("\n", "", 8),
        isolated_cores("3\n", "\n", 4),
        swap("Filename Type\n/swap file\n", "60\n"),
        huge_pages("[always] madvise never\n"),
        clock("hpet\n"),
        virtual_machine("flags\t\t: fpu hypervisor lahf_lm\n"),
    ];
    for found in worst {
        assert_eq!(found.verdict, Verdict::CouldBeBetter, "{found}");
        assert!(found.advice.is_some(), "{found}");
    }
}

#[test]
fn a_good_machine_has_nothing_to_type() {
    let good = [
        shared_memory(Some((8 << 30, 7 << 30))),
        shared_memory(Some((0, 0))),
        domain(None),
        leftover(&[]),
        cores(2),
        realtime_priority(&limits("99", "unlimited"), USER),
        realtime_priority(&limits("0", "0"), ROOT),
        locked_memory(&limits("99", "unlimited"), USER),
        locked_memory(&limits("0", "0"), ROOT),
        realtime_share("950000\n"),
        preemption("Linux version 6.12 #1 SMP PREEMPT_RT", "1\n", ""),
        preemption(
            "Linux version 6.12 #1 SMP PREEMPT_DYNAMIC",
            "",
            "quiet preempt=full",
        ),
        governor(&["performance\n".to_owned()]),
        governor(&[]),
        idle_states(
            &[["C6\n", "133\n", "1\n"], ["C1\n", "2\n", "0\n"]].map(|s| s.map(str::to_owned)),
        ),
        isolated_cores("2-3\n", "2-3\n", 2),
        swap("Filename Type\n", "60\n"),
        swap("Filename Type\n/swap file\n", "1\n"),
        huge_pages("always [madvise] never\n"),
        clock("tsc\n"),
        timer_slack("50000\n"),
        virtual_machine("flags\t\t: fpu lahf_lm\n"),
    ];
    for found in good {
        assert_eq!(found.verdict, Verdict::Ok, "{found}");
        assert_eq!(found.advice, None, "{found}");
    }
}

#[test]
fn what_a_kernel_does_not_say_is_no_fault() {
    let unsaid = [
        realtime_share(""),
        governor(&[]),
        idle_states(&[]),
        swap("", ""),
        huge_pages(""),
        clock(""),
        timer_slack(""),
        virtual_machine(""),
    ];
    for found in unsaid {
        assert_eq!(found.verdict, Verdict::Ok, "{found}");
    }
}

#[test]
fn what_the_dead_left_can_be_removed_as_it_is_typed() {
    let left = Leftover {
        domain: "arm".to_owned(),
        prefix: "/dev/shm/lariat_arm_".to_owned(),
        files: 13,
        bytes: 4_700_000,
    };
    let found = leftover(&[left]);
    assert_eq!(
        found.to_string(),
        "could be better  leftovers           killed processes left 13 files of 4.7 MB in /dev/shm\n                                     \
         → `rm /dev/shm/lariat_arm_*`\n"
    );
}
