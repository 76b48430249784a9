//! Writes small complete recordings into a folder, as seeds for the fuzzer of recordings.

fn main() -> std::io::Result<()> {
    let folder = std::env::args_os().nth(1).expect("name a folder");
    let folder = std::path::PathBuf::from(folder);
    std::fs::create_dir_all(&folder)?;
    for (number, recording) in lariat_fuzz::recording::seeds().into_iter().enumerate() {
        std::fs::write(folder.join(format!("seed{number}.mcap")), recording)?;
    }
    Ok(())
}
