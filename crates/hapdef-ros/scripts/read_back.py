"""Prints every message of a recording as three independent readers read it, to the last bit.

    python read_back.py FILE.mcap        values, by mcap, mcap-ros2-support and rosbags
    python read_back.py --rerun FILE     values, as rerun has them after converting the file
    python read_back.py --hashes FOLDER  type hashes of the definitions in FOLDER, by rosbags

A line is: reader, topic, log time, values. The values come in the order of their fields' names;
floats as the 16 hexadecimal digits of their bits, strings in JSON.
pip install mcap mcap-ros2-support rosbags; and rerun-sdk for --rerun.
"""

import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path


def flat(value, out):
    """Appends a message's values."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, bool):
        out.append(str(int(value)))
    elif isinstance(value, int):
        out.append(str(value))
    elif isinstance(value, float):
        out.append(struct.pack(">d", value).hex())
    elif isinstance(value, str):
        out.append(json.dumps(value, ensure_ascii=False))
    elif isinstance(value, (bytes, bytearray)):
        out.extend(str(byte) for byte in value)
    elif isinstance(value, dict):
        for name in sorted(value):
            flat(value[name], out)
    elif isinstance(value, (list, tuple)):
        for item in value:
            flat(item, out)
    else:
        names = getattr(value, "__slots__", None) or list(vars(value))
        # Constants are upper case; fields never are.
        for name in sorted(n for n in names if not n.startswith("_") and not n.isupper()):
            flat(getattr(value, name), out)


def line(reader, topic, time, value):
    out = []
    flat(value, out)
    print(reader, topic, time, *out)


def by_mcap(path):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            if channel.message_encoding == "json":
                text = json.loads(message.data)
                if channel.topic == "/gauges":
                    print("mcap", channel.topic, message.log_time, *text["values"])
            else:
                decoder = DecoderFactory().decoder_for(channel.message_encoding, schema)
                line("mcap-ros2", channel.topic, message.log_time, decoder(message.data))


def by_rosbags(path):
    from rosbags.highlevel import AnyReader

    with AnyReader([Path(path)]) as reader:
        connections = [c for c in reader.connections if c.msgtype != "__schemaless__"]
        for connection, time, data in reader.messages(connections=connections):
            message = reader.deserialize(data, connection.msgtype)
            line("rosbags", connection.topic, time, message)


def by_rerun(path):
    from rerun.chunk import RrdReader

    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.rrd"
        command = [str(Path(sys.executable).with_name("rerun")), "mcap", "convert", str(path)]
        done = subprocess.run([*command, "-o", str(out)], capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stderr)
        for chunk in RrdReader(str(out)).stream():
            batch = chunk.to_record_batch()
            for name in batch.schema.names:
                # Transforms become rerun's own, in 32 bits; all other messages stay as they are.
                if name.endswith(":message"):
                    times = batch.column("message_log_time").cast("int64").to_pylist()
                    for time, message in zip(times, batch.column(name).to_pylist()):
                        line("rerun", chunk.entity_path, time, message[0])


def hashes(folder):
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    types = {}
    for path in sorted(Path(folder).glob("*/*.msg")):
        name = f"{path.parent.name}/msg/{path.stem}"
        types.update(get_types_from_msg(path.read_text(), name))
    store = get_typestore(Stores.EMPTY)
    store.register(types)
    known = [get_typestore(store) for store in (Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY)]
    for name in sorted(types):
        digest = store.hash_rihs01(name)
        own = name.startswith("hapdef_msgs/")
        same = own or all(digest == other.hash_rihs01(name) for other in known)
        print(name.replace("/msg/", "/"), digest, "same" if same else "differs")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--hashes", folder]:
            hashes(folder)
        case ["--rerun", path]:
            by_rerun(path)
        case [path]:
            by_mcap(path)
            by_rosbags(path)
        case _:
            sys.exit(__doc__)
