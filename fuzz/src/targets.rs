//! What is fuzzed: each target takes any bytes and must neither panic nor run away.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hapdef_daq::hdp1::{Command, Decoder, Encoder, Event, Header, MAJOR_VERSION};
use hapdef_daq::record::recover;
use hapdef_live::estimator::Hapdefx;
use hapdef_mesh::{DeckParams, DeckReading, GltfParams, read_deck_with, read_gltf};
use hapdef_nets::{Activation, Mlp, MlpSpec, Net, Scale, TrainParams, TrainRecord};

/// A target: its name, and what is done with the bytes; `folder` is for files.
#[derive(Clone, Copy)]
pub struct Target {
    /// Name of it and of its folder in the corpus.
    pub name: &'static str,
    /// Takes the bytes.
    pub run: fn(bytes: &[u8], folder: &Path),
}

/// Every target.
pub const TARGETS: [Target; 7] = [
    target("decoder", decoder),
    target("hello", hello),
    target("recover", recover_file),
    target("scene", scene),
    target("gltf", gltf),
    target("deck", deck),
    target("safetensors", safetensors),
];

const fn target(name: &'static str, run: fn(&[u8], &Path)) -> Target {
    Target { name, run }
}

/// Bytes from a device, in pieces whose length the first byte tells.
fn decoder(bytes: &[u8], _: &Path) {
    let Some((&first, rest)) = bytes.split_first() else {
        return;
    };
    let mut decoder = Decoder::new();
    let mut n_commands = 0;
    for piece in rest.chunks(1 + usize::from(first)) {
        decoder.push(piece, &mut |event| {
            n_commands += usize::from(matches!(event, Event::Command(Command::GetHello)));
        });
    }
    assert!(n_commands <= bytes.len());
}

/// A payload with a header and the right CRC before the decoder: most bytes would not come through
/// it otherwise. Then a DATA packet of the same bytes.
fn hello(bytes: &[u8], _: &Path) {
    let mut encoder = Encoder::new();
    let mut out = Vec::new();
    for kind in [0x02, 0x01, 0x03, 0x04, 0x05] {
        let header = Header {
            kind,
            major: MAJOR_VERSION,
            flags: Default::default(),
            schema: bytes.get(30).copied().unwrap_or(0),
            n_channels: bytes.get(1).copied().unwrap_or(0),
            seq: 0,
            t_us: 0,
        };
        // Too long a payload is refused, as it should be.
        let _ = encoder.packet(header, bytes, &mut out);
    }
    let mut decoder = Decoder::new();
    decoder.push(&out, &mut |event| {
        if let Event::Data(data) = event {
            for scan in 0..usize::from(data.hello.n_scans) {
                assert_eq!(data.bits(scan).count(), data.hello.channels.len());
                let _ = data.t_us(scan);
            }
        }
    });
}

/// A file as it is, and with the CRCs of its chunks made right, so that damage within chunks is read.
fn recover_file(bytes: &[u8], folder: &Path) {
    saved(bytes, folder);
    let mut sealed = bytes.to_vec();
    seal_chunks(&mut sealed);
    saved(&sealed, folder);
}

fn saved(bytes: &[u8], folder: &Path) {
    let path = written(bytes, folder, "damaged.mcap");
    let out = folder.join("saved.mcap");
    if let Ok(info) = recover(&path, &out) {
        // What was saved can be saved again, whole.
        let again = recover(&out, &folder.join("again.mcap"));
        let again = again.expect("a recovered file can be read");
        assert_eq!((again.n_frames, again.damage.n_damaged), (info.n_frames, 0));
    }
}

/// Goes from record to record as their lengths say.
fn seal_chunks(file: &mut [u8]) {
    const CHUNK: u8 = 6;
    // Opcode and length, then two times, the size, the CRC, no compression, the size again.
    const PREFIX: usize = 9;
    const CRC: usize = 24;
    const RECORDS: usize = 40;
    let mut at = 8;
    while let Some(len) = file.get(at + 1..at + PREFIX) {
        let len = u64::from_le_bytes(len.try_into().expect("eight bytes"));
        let start = at + PREFIX;
        let end = start.saturating_add(usize::try_from(len).unwrap_or(usize::MAX));
        if end > file.len() {
            return;
        }
        if file[at] == CHUNK && start + RECORDS <= end {
            let crc = crc32(&file[start + RECORDS..end]);
            file[start + CRC..][..4].copy_from_slice(&crc.to_le_bytes());
        }
        at = end;
    }
}

/// CRC-32 of IEEE 802.3, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let turn = |crc: u32| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
    let byte = |crc: u32, byte: &u8| (0..8).fold(crc ^ u32::from(*byte), |crc, _| turn(crc));
    !bytes.iter().fold(u32::MAX, byte)
}

fn scene(bytes: &[u8], folder: &Path) {
    let path = written(bytes, folder, "scene.json");
    let _ = hapdef::scene::read_scene(&path);
}

fn gltf(bytes: &[u8], folder: &Path) {
    let path = written(bytes, folder, "surface.glb");
    let params =
        GltfParams { max_vertices: 100_000, max_triangles: 100_000, ..GltfParams::default() };
    let _ = read_gltf(&path, &params);
}

/// The first byte chooses the deck's kind; it is read whole and for a scene.
fn deck(bytes: &[u8], folder: &Path) {
    let Some((&first, rest)) = bytes.split_first() else {
        return;
    };
    let name = ["deck.inp", "deck.dat", "deck.cdb", "deck.msh"][usize::from(first % 4)];
    let path = written(rest, folder, name);
    for reading in [DeckReading::Whole, DeckReading::Supports, DeckReading::Mesh] {
        let _ = read_deck_with(&path, &DeckParams { reading, ..DeckParams::default() });
    }
}

/// A bundle, a net in one file, the places of the paper's chain, and a checkpoint whose weights are
/// these bytes.
fn safetensors(bytes: &[u8], folder: &Path) {
    let _ = hapdef_live::Bundle::from_bytes(bytes, "fuzz");
    let _ = Net::from_bytes(bytes, "fuzz");
    let _ = Hapdefx::from_files(&chain_files(bytes));
    let path = folder.join("net.json");
    if !path.exists() {
        save_net(&path);
    }
    written(bytes, folder, "net-0.safetensors");
    let _ = hapdef_nets::load(&path);
}

/// The paper's chain with small nets and these bytes for its places.
fn chain_files(places: &[u8]) -> BTreeMap<String, Vec<u8>> {
    let net = small_net().to_bytes().expect("a small net");
    let nets = ["transfer", "reconstruction", "sensitivity"];
    let nets = nets.map(|name| (format!("{name}.safetensors"), net.clone()));
    let places = ("places.safetensors".to_owned(), places.to_vec());
    nets.into_iter().chain([places]).collect()
}

/// Its JSON file, and `net-0.safetensors` beside it.
fn save_net(path: &Path) {
    let record = TrainRecord::new(TrainParams::paper(1));
    hapdef_nets::save(path, &small_net(), &record, None).expect("the folder can be written");
}

/// A net of nine numbers.
fn small_net() -> Net {
    let spec = MlpSpec { inputs: 2, hidden: vec![2], outputs: 1, activation: Activation::Relu };
    let mlp = Mlp::random(&spec, 1).expect("widths above 0");
    Net::new(mlp, Scale::identity(2), Scale::identity(1)).expect("scales that fit")
}

fn written(bytes: &[u8], folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("the folder can be written");
    path
}
