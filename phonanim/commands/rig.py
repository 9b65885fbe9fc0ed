"""`phonanim rig`: make, check and fit rigs for new characters."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click

from phonanim.commands import Console, console_options
from phonanim.commands._export import NAMES
from phonanim.commands._renamed import renamed_option

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)
PLACE = click.Path(path_type=Path)
BAD = 2


@click.group()
def command() -> None:
    """Make a rig for your own character, or list the shipped rigs.

    \b
    Examples:
      phonanim rig list
      phonanim rig fit hero.glb              a head with blendshapes, fitted without an artist
      phonanim rig landmarks hero.glb        a page to mark its face on, where that is unsure
      phonanim rig new hero                  any other rig: eight poses to copy, a file to fill in
      phonanim rig check hero/hero.toml
      phonanim animate line.TextGrid -o line.csv --rig hero/hero.toml
    """


@command.command("list")
@console_options
def list_command(console: Console) -> None:
    """List the shipped rigs.

    \b
    Examples:
      phonanim rig list
      phonanim rig list --json
    """
    from phonanim.rig import load_rig, rig_names

    rigs = [load_rig(name) for name in rig_names()]
    facts = [
        {"name": r.name, "title": r.title, "controls": list(r.controls), "source": r.source} for r in rigs
    ]
    console.print_result(facts, "\n".join(f"{rig.name:<14} {rig.title}" for rig in rigs))


@command.command("new")
@click.argument("folder", type=PLACE)
@click.option("--head", type=FILE, help="A GLB whose morph targets become the controls.")
@click.option("--model", default="default", help="The model whose face the poses show.")
@console_options
def new_command(folder: Path, head: Path | None, model: str, console: Console) -> None:
    """Start a rig: write eight reference poses to copy, and a file to fill in, to FOLDER.

    \b
    Examples:
      phonanim rig new hero
      phonanim rig new hero --head hero.glb
    """
    from phonanim.commands._new_rig import write_rig_template
    from phonanim.pipeline import load_model
    from phonanim.rig.character import load_character

    controls = load_character(head).targets if head else ()
    files = write_rig_template(folder, controls, load_model(model).face)
    console.print(f"look at {files[1]} and fill in {files[0]}; then: phonanim rig check {files[0]}")
    console.print_result({"files": [str(path) for path in files]})


@command.command("check")
@click.argument("rig", type=FILE)
@renamed_option(
    "--contact-sheet", "--sheet", type=PLACE, help="Draw the character in all poses, as PNG; needs its head."
)
@click.option("--phones", type=PLACE, help="Draw AA IY UW W SH F M beside the shipped head, as PNG.")
@click.option("--model", default="default", help="The model whose face the rig is for.")
@console_options
def check_command(rig: Path, sheet: Path | None, phones: Path | None, model: str, console: Console) -> int:
    """Report everything that is missing or wrong in a rig's file; exit 2 if anything is.

    Where the rig names its head and has a table of its mouth, three sentences move it beside the shipped
    head: correlation, slope, what the shapes allow, and what falls short are printed.

    \b
    Examples:
      phonanim rig check hero/hero.toml
      phonanim rig check hero.toml --contact-sheet hero.png
      phonanim rig check hero.toml --phones phones.png
    """
    from phonanim.commands._rig_quality import check_quality, draw, quality_lines
    from phonanim.rig import load_rig
    from phonanim.rig.read import read_document, rig_problems, rig_warnings

    found = rig_problems(read_document(rig))
    if found:
        console.print_result({"problems": found, "doubts": []}, "\n".join(f"{rig}: {line}" for line in found))
        return BAD
    loaded = load_rig(str(rig))
    unsure = rig_warnings(loaded)
    good = f"{rig}: good, {len(loaded.controls)} controls"
    quality = check_quality(loaded, model, phones)
    facts: dict[str, object] = {"problems": [], "doubts": unsure}
    if quality is not None:
        console.print("beside the shipped head, on speech:\n" + "\n".join(quality_lines(quality)))
        facts["reach"], facts["short"] = quality.reach, list(quality.short)
    console.print_result(facts, "\n".join([*(f"{rig}: {line}" for line in unsure), good]))
    if sheet:
        draw(rig, sheet, model)
    return 0


@command.command("phones")
@click.argument("alignments", type=click.Path(exists=True, path_type=Path))
@click.option("--rig", "rigs", multiple=True, default=("arkit",), help="A rig's name or file; repeat.")
@click.option("--files", type=click.IntRange(1), default=40, show_default=True, help="Alignments to animate.")
@click.option("--table", is_flag=True, help="Print what each phone shows, too.")
@console_options
def phones_command(
    alignments: Path, rigs: tuple[str, ...], files: int, table: bool, console: Console
) -> None:
    """Measure the mouth that rigs show at each phone of natural speech, on their own heads.

    ALIGNMENTS is a folder of TextGrids, searched within, or one file. Millimetres are those of the reference
    face. A rig without a head that goes through another is shown on the other's; for stepped rigs it counts
    how many phones show theirs.

    \b
    Examples:
      phonanim rig phones aligned/ --rig arkit --rig vrm
      phonanim rig phones aligned/ --rig hero.toml --table
    """
    from phonanim.commands._rig_phones import checks_text, rig_phones, spread_over, table_text

    paths, found = spread_over(alignments, files), {}
    with console.progress("phones") as progress:
        for number, name in enumerate(rigs):
            found[name] = rig_phones(name, paths)
            progress((number + 1) / len(rigs))
    parts = [f"{name}\n{table_text(each)}\n" for name, (each, _, _) in found.items() if table and each]
    checks = {name: made for name, (_, made, _) in found.items() if made}
    parts += [checks_text(checks)] if checks else []
    parts += [f"{name}: {remark}" for name, (_, _, remarks) in found.items() for remark in remarks]
    console.print_result(
        {
            name: {"phones": each, "checks": [asdict(check) for check in made], "remarks": remarks}
            for name, (each, made, remarks) in found.items()
        },
        "\n".join(parts),
    )


@command.command("fit")
@click.argument("head", type=FILE)
@click.option("-o", "--output", type=PLACE, help="The rig's file; HEAD with .toml when left out.")
@click.option(
    "--landmarks", type=FILE, help="Positions of the face's landmarks on it; suggested when left out."
)
@renamed_option("--contact-sheet", "--sheet", type=PLACE, help="Draw the character in all poses, as PNG.")
@click.option("--model", default="default", help="The model whose face the rig is for.")
@NAMES
@console_options
def fit_command(
    head: Path, output: Path | None, landmarks: Path | None, sheet: Path | None, model: str, console: Console
) -> None:
    """Make a rig for a GLB or VRM head with blendshapes, without an artist.

    Writes the rig (poses), its direct map, and the landmark table, which you can correct and pass back.

    \b
    Examples:
      phonanim rig fit hero.glb
      phonanim rig fit hero.vrm -o rigs/hero.toml --contact-sheet hero.png
      phonanim rig fit hero.glb --landmarks hero.landmarks.csv
    """
    from dataclasses import replace

    from phonanim.commands._rig_quality import draw, quality_lines
    from phonanim.errors import RigError
    from phonanim.pipeline import load_model
    from phonanim.rig.character import load_character
    from phonanim.rig.fit_character import fit_character
    from phonanim.rig.fit_quality import check_alive, fit_quality
    from phonanim.rig.landmarks import read_landmarks, write_landmarks
    from phonanim.rig.orientation import orientation_warnings
    from phonanim.rig.write import write_rig

    target = output or head.with_suffix(".toml")
    face, character = load_model(model).face, load_character(head)
    given = read_landmarks(landmarks) if landmarks else None
    rig, spots = fit_character(character, face, target.stem, given)
    quality = fit_quality(rig, character, spots, face)
    check_alive(quality, str(head))
    table = target.with_suffix(".landmarks.csv")
    if landmarks and given is spots:
        table = landmarks
    elif table == landmarks:
        raise RigError(f"{landmarks}: all landmarks would be written over it; rename it, or give another -o")
    else:
        write_landmarks(table, spots)
    write_rig(target, replace(rig, head=head, landmarks=table))
    if sheet:
        draw(target, sheet, model)
    for odd in orientation_warnings(character):
        console.print(f"{head}: {odd}; its curves are correct nevertheless")
    console.print(
        f"{len(rig.speech)} of {len(rig.controls)} controls speak; beside the shipped head, on speech:"
    )
    console.print("\n".join(quality_lines(quality)))
    console.print_result(
        {
            "rig": str(target),
            "landmarks": str(table),
            "speech": list(rig.speech),
            "measures": {name: asdict(followed) for name, followed in quality.measures.items()},
            "open_at_closures": quality.open_at_closures,
            "reach": quality.reach,
            "short": list(quality.short),
        },
        str(target),
    )


@command.command("landmarks")
@click.argument("head", type=FILE)
@click.option("-o", "--output", type=PLACE, help="The page; HEAD with .landmarks.html when left out.")
@click.option("--landmarks", type=FILE, help="A landmark table of this head to correct.")
@console_options
def landmarks_command(head: Path, output: Path | None, landmarks: Path | None, console: Console) -> None:
    """Write a page on which you click the points of the face on a GLB or VRM head, where `rig fit` is unsure.

    The page works offline and saves a table for `phonanim rig fit --landmarks`, which finds the other
    landmarks from these ten to fifteen points. The names of the shapes are not needed.

    \b
    Examples:
      phonanim rig landmarks hero.glb -o hero.html       open it in a browser, mark the points, save
      phonanim rig fit hero.glb --landmarks hero.points.csv
      phonanim rig landmarks hero.glb --landmarks hero.landmarks.csv
    """
    from phonanim.rig.landmarks import read_landmarks
    from phonanim.viewer.marking_page import write_marking_page

    page = output or head.with_suffix(".landmarks.html")
    write_marking_page(head, page, read_landmarks(landmarks) if landmarks else None)
    console.print(f"open {page} in a browser, mark the points and save; its last line says what to run next")
    console.print_result({"page": str(page)}, str(page))


@command.command("transfer")
@click.option(
    "--from", "source", type=click.Choice(["shipped"]), default="shipped", help="Head whose shapes to use."
)
@click.option(
    "--to",
    "mesh",
    type=FILE,
    required=True,
    help="A head (OBJ, PLY, STL, OFF, GLB), y up, facing z.",
)
@click.option("-o", "--output", type=PLACE, help="The GLB to write; MESH with .shapes.glb when left out.")
@console_options
def transfer_command(source: str, mesh: Path, output: Path | None, console: Console) -> None:
    """Give a head without blendshapes the 52 of the shipped head, by deformation transfer.

    Teeth, eyes, tongue and lashes are detected by the names of their parts. The detected landmarks are
    written beside the GLB, for `phonanim rig fit --landmarks`.

    \b
    Examples:
      phonanim rig transfer --from shipped --to hero.obj
      phonanim rig transfer --to hero.obj -o hero.glb
      phonanim rig fit hero.glb --landmarks hero.landmarks.csv
    """
    from phonanim.rig.head import load_head
    from phonanim.rig.landmarks import shipped_landmarks, write_landmarks
    from phonanim.rig.mesh_file import load_mesh
    from phonanim.rig.meshes import write_head
    from phonanim.rig.transfer import transfer

    target = output or mesh.with_suffix(".shapes.glb")
    head, spots, report = transfer(load_head(), shipped_landmarks(), load_mesh(mesh))
    table = target.with_suffix(".landmarks.csv")
    write_landmarks(table, spots)
    write_head(target, head)
    console.print(
        f"{report.matched:.0%} of the skin's triangles correspond to the {source} head's; the rest stays"
    )
    for part, follows in report.carried.items():
        console.print(f"{part} follows {follows}")
    if report.straightened:
        console.print(f"{report.straightened} shapes turned triangles over, which were turned back")
    if report.flipped:
        console.print(f"{report.flipped} triangles are still turned over by some shape; look at them")
    facts = {"head": str(target), "landmarks": str(table), **asdict(report)}
    console.print_result(facts, f"{target}\n{table}")
