"""Tiny data sets in the layouts of their owners, one function each, named after the data set."""

import json
import pickle
import wave

import numpy as np

RATE = 8000


def numbers(*shape, seed=0):
    return np.random.default_rng(seed).normal(size=shape).astype(np.float32)


def wav(path, seconds=0.2, channels=1):
    path.parent.mkdir(parents=True, exist_ok=True)
    with wave.open(str(path), "wb") as stream:
        stream.setnchannels(channels)
        stream.setsampwidth(2)
        stream.setframerate(RATE)
        stream.writeframes((1000 * numbers(int(seconds * RATE), channels)).astype("<i2").tobytes())


def array(path, values):
    path.parent.mkdir(parents=True, exist_ok=True)
    np.save(path, values)


def text(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content, encoding="utf-8")


def textgrid(*intervals):
    rows = "".join(f'{start}\n{end}\n"{label}"\n' for start, end, label in intervals)
    end = intervals[-1][1]
    head = 'File type = "ooTextFile"\nObject class = "TextGrid"\n\n'
    return f'{head}0\n{end}\n<exists>\n1\n"IntervalTier"\n"phones"\n0\n{end}\n{len(intervals)}\n{rows}'


PHONES = textgrid((0, 0.1, "sil"), (0.1, 0.2, "m"))


def biwi(folder):
    for speaker in ("F2", "F1"):
        for sentence in ("01", "e01", "e33", "e40"):
            for frame in (1, 2, 10):
                path = folder / "faces" / speaker / sentence / f"frame_{frame}.vl"
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(np.uint32(4).tobytes() + numbers(4, 3, seed=frame).tobytes())
            wav(folder / "audio" / f"{speaker}_{sentence}_cut.wav")


def vocaset(folder):
    speakers = ("FaceTalk_170728_03272_TA", "FaceTalk_170908_03277_TA", "FaceTalk_170731_00024_TA")
    sentences = ("sentence20", "sentence21")
    pairs = [(speaker, sentence) for speaker in speakers for sentence in sentences]
    array(folder / "data_verts.npy", numbers(3 * len(pairs), 5, 3))
    index, audio = {}, {}
    for place, (speaker, sentence) in enumerate(pairs):
        index.setdefault(speaker, {})[sentence] = {frame: 3 * place + frame for frame in (2, 0, 1)}
        samples = np.arange(100, dtype=np.int16) * 100
        audio.setdefault(speaker, {})[sentence] = {"sample_rate": 22000, "audio": samples}
    (folder / "subj_seq_to_idx.pkl").write_bytes(pickle.dumps(index, protocol=2))
    (folder / "raw_audio_fixed.pkl").write_bytes(pickle.dumps(audio, protocol=2))


def multiface(folder, sentences=50):
    for number in range(13):
        capture = folder / f"m--2018{number:04d}--0000--{number}--GHS"
        for sentence in [f"SEN_{letter}_{number:02d}" for number in range(25) for letter in "bA"][:sentences]:
            mesh = capture / "tracked_mesh" / sentence
            mesh.mkdir(parents=True)
            if number:
                (mesh / "000102.bin").write_bytes(numbers(4, 3).tobytes())
            else:
                text(mesh / "000102.obj", "v 1 2 3\nv 4 5 6\nvt 0 0\nf 1/1 2/1 1/1\n")
                text(mesh / "000102_transform.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n")
        wav(capture / "audio" / "SEN_A_00.wav", channels=5)


def beat(folder):
    for speaker, name in (("1", "wayne"), ("2", "scott")):
        for kind, first in (("0", 1), ("0", 65), ("1", 1)):
            path = folder / speaker / f"{speaker}_{name}_{kind}_{first}_{first}.json"
            frames = [{"weights": [0.1, 0.2], "time": index / 60, "rotation": []} for index in range(60 * 21)]
            text(path, json.dumps({"names": ["jawOpen", "mouthClose"], "frames": frames}))
            wav(path.with_suffix(".wav"), 21.0)
            text(
                path.with_suffix(".TextGrid"), textgrid((0, 9.9, "sil"), (9.9, 10.2, "m"), (10.2, 21, "sil"))
            )


def uudamm(folder):
    for speaker in ("S1", "S2"):
        for number in (1, 2, 3, 2537, 3000):
            array(folder / "vertices_npy" / f"{speaker}_{number}.npy", numbers(300, 192))
            wav(folder / "wav" / f"{speaker}_{number}.wav")


def facegood(folder, takes=4, frames=40):
    rng, names = np.random.default_rng(3), ("jawDown", "lipsUp", "noseStill")
    kept = {f"take_{n}": rng.random((frames + n, 3), np.float32) * (1, 1, 0) for n in range(takes)}
    np.savez(folder / "curves.npz", fps=30, names=names, **kept)
    for n in range(takes):
        wav(folder / f"take_{n}.wav", (frames + n) / 30)


def listed(folder, motion, width, lists=True):
    for number in range(10):
        array(folder / motion / f"{number:04d}.npy", numbers(6, *width))
        wav(folder / "wav" / f"{number:04d}.wav")
    text(folder / "phones" / "0003.TextGrid", PHONES)
    if lists:
        text(folder / "train.lst", "0000\n0001\n")
        text(folder / "test.lst", "0002\n")


def imt22(folder):
    listed(folder, "ema", (10, 3))


def imft23(folder):
    listed(folder, "params", (67,), lists=False)


def kb2k(folder):
    listed(folder, "aam", (104,))


def est(channels, values, rate, binary=True):
    """An EST track; rows of NaN are marked as missing."""
    there = np.isfinite(values).all(axis=1)
    table = np.column_stack([np.arange(len(values)) / rate, there, np.nan_to_num(values)])
    head = ["EST_File Track", f"DataType {'binary' if binary else 'ascii'}", "ByteOrder 01"]
    head += [f"NumFrames {len(values)}", f"NumChannels {len(channels)}", "EqualSpace 0", "BreaksPresent true"]
    head += [
        "CommentChar ;",
        "",
        *(f"Channel_{i} {name}" for i, name in enumerate(channels)),
        "EST_Header_End",
    ]
    rows = "".join(" ".join(map(str, row)) + "\n" for row in table).encode()
    return ("\n".join(head) + "\n").encode() + (table.astype("<f4").tobytes() if binary else rows)


def mngu0(folder):
    coils = ("T3", "T2", "T1", "ref", "jaw", "upperlip", "lowerlip")
    channels = [f"{coil}_{part}" for coil in coils for part in ("px", "py", "pz", "ox", "oy", "rms")]
    for number in (1, 10, 20, 30):
        name = f"mngu0_s1_{number:04d}"
        values = numbers(5, len(channels), seed=number)
        values[2] = np.nan
        path = folder / "mngu0_s1_ema_basic_1.1.0" / f"{name}.ema"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(est([*channels, "taxdist"], np.column_stack([values, values[:, 0]]), 200))
        wav(folder / "mngu0_s1_wav_16kHz_1.1.0" / f"{name}.wav")
        text(folder / "mngu0_s1_lab_1.1.1" / f"{name}.lab", "#\n0.1 26 #\n0.2 26 m\n")
    sets = folder / "mngu0_s1_ema_filesets_1.0.0" / "mngu0_s1_ema_filesets"
    for split, number in (("train", 1), ("validation", 10), ("test", 20)):
        text(sets / f"{split}files.txt", f"mngu0_s1_{number:04d}\n")


def mocha(folder):
    channels = [f"{coil}_{axis}" for axis in "xy" for coil in ("ui", "li", "ul", "ll", "tt", "tb", "td", "v")]
    for speaker in ("fsew0", "msak0"):
        for number in (1, 2, 6):
            path = folder / f"{speaker}_v1.1" / f"{speaker}_{number:03d}.ema"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(est(channels, 1000 * numbers(5, 16), 500, binary=speaker == "fsew0"))
            wav(path.with_suffix(".wav"))
            text(path.with_suffix(".lab"), "0.0 0.1 sil\n0.1 0.2 m\n")


def hprc(folder):
    from scipy.io import savemat

    for name in ("F01_B01_S01_R01_N", "M01_B01_S02_R01_F"):
        phones = [{"LABEL": "SIL", "OFFS": [0.0, 0.1]}, {"LABEL": "M", "OFFS": [0.1, 0.2]}]
        tracks = [signal("AUDIO", 44100, numbers(200, 1) / 10, phones)]
        tracks += [signal(sensor, 100, numbers(5, 6), []) for sensor in ("TR", "TB", "TT", "UL", "LL", "JAW")]
        (folder / name[:3]).mkdir(exist_ok=True)
        savemat(folder / name[:3] / f"{name}.mat", {name: structures(tracks)})


def signal(name, rate, values, phones):
    return {"NAME": name, "SRATE": rate, "SIGNAL": values, "PHONES": structures(phones)}


def structures(rows):
    if not rows:
        return np.zeros(0)
    found = np.empty(len(rows), dtype=[(field, object) for field in rows[0]])
    for index, row in enumerate(rows):
        found[index] = tuple(row.values())
    return found
