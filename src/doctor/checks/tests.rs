use std::collections::BTreeMap;

use lariat_wire::{ChannelState, Leftover, Member};

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
    // The worst result of every other check.
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
        leftover(&[], None, &[]),
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
        domain: Some("arm".to_owned()),
        prefix: "/dev/shm/lariat_arm_".to_owned(),
        files: 13,
        bytes: 4_700_000,
    };
    let left = std::slice::from_ref(&left);
    assert_eq!(
        leftover(left, None, &[]).to_string(),
        "could be better  leftovers: left: 13 files of 4.7 MB in /dev/shm, of killed\n                 \
         processes in the domain arm\n                 → `lariat doctor --clean`\n"
    );
    let removed = leftover(left, Some(&[]), &[]);
    assert_eq!(removed.verdict, Verdict::Ok);
    assert!(removed.found.starts_with("removed: 13 files"), "{removed}");
    let kept = leftover(
        left,
        Some(&["/dev/shm/lariat_arm_1 (not permitted)".to_owned()]),
        &[],
    );
    assert_eq!(kept.advice.as_deref(), Some("`sudo lariat doctor --clean`"));
    assert!(kept.found.contains("lariat_arm_1"), "{kept}");
}

#[test]
fn what_other_users_have_in_memory_is_said_with_who_can_judge_it() {
    let others = [("root".to_owned(), 12, 3_000_000)];
    let found = leftover(&[], None, &others);
    assert_eq!(found.verdict, Verdict::Ok);
    assert_eq!(
        found.found,
        "no dead process has left shared memory; 12 files of 3.0 MB are root's: whether that is in use, `sudo lariat \
         doctor` tells"
    );
}

#[test]
fn the_folder_that_all_users_once_shared_is_left_over() {
    let shared = Leftover {
        domain: None,
        prefix: "/dev/shm/iox2_".to_owned(),
        files: 0,
        bytes: 0,
    };
    let found = leftover(&[shared], None, &[]);
    assert_eq!(
        found.found,
        "left: /tmp/iceoryx2, the folder of an older lariat"
    );
    assert_eq!(found.advice.as_deref(), Some("`lariat doctor --clean`"));
}

#[test]
fn files_of_another_user_are_a_finding() {
    let mut others = BTreeMap::new();
    assert_eq!(rights("ann", 0, &others).verdict, Verdict::Ok);
    assert_eq!(
        rights("ann", 9, &others).found,
        "all 9 files of the domain are ann's"
    );
    others.insert("root".to_owned(), 12);
    let found = rights("ann", 9, &others);
    assert_eq!(found.verdict, Verdict::CouldBeBetter);
    assert!(
        found
            .found
            .starts_with("12 files of the domain are root's, and this is ann"),
        "{found}"
    );
    assert!(
        found
            .advice
            .is_some_and(|advice| advice.contains("sudo -u root lariat"))
    );
}

#[test]
fn mixed_releases_on_a_rig_are_a_finding() {
    let member = |rig: &str, stage: &str, version: &str| Member {
        rig: rig.to_owned(),
        stage: stage.to_owned(),
        pid: 1,
        version: version.to_owned(),
        folder: "/".into(),
        settings: String::new(),
    };
    let of = |members: &[Member]| versions(members, &[], "0.2.0");
    assert_eq!(of(&[]).found, "0.2.0; no rig runs");
    let same = [member("arm", "fit", "0.2.0"), member("leg", "fit", "0.2.0")];
    assert_eq!(of(&same).found, "0.2.0 on every rig that runs: arm, leg");
    let mixed = [
        member("arm", "extract", "0.1.0"),
        member("arm", "fit", "0.2.0"),
    ];
    let found = of(&mixed);
    assert_eq!(
        (found.verdict, found.found.as_str()),
        (Verdict::CouldBeBetter, "rig arm: extract 0.1.0, fit 0.2.0")
    );
    assert!(
        found
            .advice
            .is_some_and(|advice| advice.contains("lariat --version"))
    );
    let another = of(&[member("leg", "fit", "0.1.0")]);
    assert_eq!(
        another.found,
        "rig leg: fit 0.1.0, and this lariat is 0.2.0"
    );
    // Messages of two releases may differ although the release numbers are the same.
    let channel = ChannelState {
        rig: "arm".parse().expect("a name"),
        channel: "descriptors",
        message: "lariat.Descriptors.v3".into(),
        ours: "lariat.Descriptors.v4".into(),
        lossless: false,
        buffer: 8,
        most_readers: 24,
        ends: None,
    };
    let found = versions(&same, &[channel], "0.2.0");
    assert_eq!(found.verdict, Verdict::CouldBeBetter);
    assert!(
        found.found.contains("carries lariat.Descriptors.v3"),
        "{found}"
    );
}

#[test]
fn few_open_files_are_a_finding() {
    let limits = |most: &str| {
        format!("Max open files            {most}                 4096                 files\n")
    };
    assert_eq!(open_files(&limits("1024")).verdict, Verdict::Ok);
    assert_eq!(open_files(&limits("64")).verdict, Verdict::CouldBeBetter);
    assert_eq!(open_files(&limits("unlimited")).found, "unlimited");
}
