//! hapdef in five small programs, each of which is a test with a number.
//!
//! ```text
//! cargo run --release --example tour -- press-one
//! cargo run --release --example tour -- two-fingers
//! cargo run --release --example tour -- own-limb limb.glb 1.0
//! cargo run --release --example tour -- own-board lines.csv 0.5
//! cargo run --release --example tour -- replay press.mcap
//! ```
//!
//! Read them in this order: `press_one.rs` is the whole way from a scene to a contact. Without a file
//! of your own the last three make one up. The numbers are the wall's thickness, mm, and the strain
//! that one count of your board is, µε; they are 1.0 and 0.5 where nothing is said.
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

mod own_board;
mod own_limb;
mod press_one;
mod replay;
mod scene;
mod two_fingers;

use anyhow::{Result, bail};

fn main() -> Result<()> {
    let mut words = std::env::args().skip(1);
    let name = words.next().unwrap_or_default();
    let file = words.next().map(std::path::PathBuf::from);
    match name.as_str() {
        "press-one" => {
            let pressed = press_one::press_one()?;
            println!("the gauges read {:.2?} µε", pressed.readings_ue);
            println!("found {:.3} N, {:.4} mm off", pressed.force_n, pressed.miss_mm);
        }
        "two-fingers" => {
            for (force_n, miss_mm) in two_fingers::two_fingers()? {
                println!("found {force_n:.3} N, {miss_mm:.4} mm off");
            }
        }
        "own-limb" => {
            let wall_mm = words.next().map_or(Ok(1.0), |word| word.parse())?;
            let limb = own_limb::own_limb(file.as_deref(), wall_mm)?;
            println!("{} nodes, {} gauges", limb.n_nodes, limb.n_gauges);
            println!("a newton moves the best gauge by {:.2} µε", limb.median_best_ue);
            println!("10 N found {:.4} mm off", limb.miss_mm);
        }
        "own-board" => {
            let count = words.next().map(|word| word.parse()).transpose()?;
            let ue_per_count = count.unwrap_or(own_board::UE_PER_COUNT);
            println!("{ue_per_count} µε per count");
            for found in own_board::own_board(file.as_deref(), ue_per_count)? {
                let at_mm = found.position_m.coords * 1e3;
                print!(
                    "{:.3} N at ({:.1}, {:.1}, {:.1}) mm",
                    found.force_n, at_mm.x, at_mm.y, at_mm.z
                );
                match found.miss_mm {
                    Some(miss_mm) => println!(", {miss_mm:.3} mm from the made-up press"),
                    None => println!(),
                }
            }
        }
        "replay" => {
            let played = replay::replay(file)?;
            println!("{} frames, {} with contacts", played.n_frames, played.n_touched);
            println!("the last contact: {:.3} N", played.last_n);
        }
        other => {
            bail!("expected press-one, two-fingers, own-limb, own-board or replay, found {other:?}")
        }
    }
    Ok(())
}
