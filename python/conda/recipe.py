"""The recipe for conda-forge of a source distribution, checked as `rattler-build` reads it.

    python python/conda/recipe.py SDIST FOLDER

writes FOLDER/recipe.yaml: `recipe.yaml` of this folder with the version and the checksum of the
distribution. What the recipe needs must be in the distribution, and the versions that it asks for
must be those of `pyproject.toml`; all that it may be built for is rendered.
"""

from __future__ import annotations

import hashlib
import re
import sys
import tarfile
import tomllib
from pathlib import Path

import rattler_build
import yaml

TEMPLATE = Path(__file__).parent / "recipe.yaml"
PLATFORMS = ("linux-64", "linux-aarch64", "osx-64", "osx-arm64", "win-64")
#: Files that the build of conda makes.
MADE = {"THIRDPARTY.yml"}
#: The compilers of conda-forge, which its own settings name.
VARIANTS = {"c_stdlib": ["sysroot"], "c_stdlib_version": ["2.17"], "rust_compiler": ["rust"]}


def filled(sdist: Path) -> str:
    """The text of the recipe of a source distribution."""
    version = re.fullmatch(r"emitree-(.+)\.tar\.gz", sdist.name)
    if version is None:
        sys.exit(f"{sdist}: expected a name such as emitree-0.1.0.tar.gz")
    checksum = hashlib.sha256(sdist.read_bytes()).hexdigest()
    text = TEMPLATE.read_text(encoding="utf-8").replace('"VERSION"', f'"{version[1]}"')
    return text.replace("SHA256", checksum)


def defects(recipe: dict, sdist: Path) -> list[str]:
    """What the distribution lacks, or has otherwise."""
    with tarfile.open(sdist) as archive:
        files = {name.partition("/")[2] for name in archive.getnames()}
        file = archive.extractfile(f"{sdist.name.removesuffix('.tar.gz')}/pyproject.toml")
        if file is None:
            return [f"{sdist}: it has no pyproject.toml"]
        metadata = tomllib.loads(file.read().decode("utf-8"))
    licences = set(recipe["about"]["license_file"]) - MADE
    needed = [*sorted(licences), "python/tests/smoke.py"]
    found = [f"{sdist}: it has no {file}" for file in needed if file not in files]
    project, about, requirements = metadata["project"], recipe["about"], recipe["requirements"]
    host = [spaced(package) for package in metadata["build-system"]["requires"]]
    run = [spaced(package) for package in project["dependencies"]]
    for wanted, given in (
        (project["description"], [about["summary"]]),
        (project["license"], [about["license"]]),
        (project["requires-python"], [f">={recipe['context']['python_min']}"]),
        *((package, requirements["host"]) for package in host),
        *((package, requirements["run"]) for package in run),
    ):
        if wanted not in given:
            found.append(f"{TEMPLATE}: expected `{wanted}` of pyproject.toml, and not {given}")
    return found


def spaced(package: str) -> str:
    """A requirement as conda writes it: `numpy >=1.26`."""
    name = re.match(r"[\w-]+", package)
    return f"{name[0]} {package[name.end() :]}" if name else package


def main() -> None:
    """Writes and checks the recipe."""
    sdist, folder = (Path(argument) for argument in sys.argv[1:])
    text = filled(sdist)
    found = defects(yaml.safe_load(text), sdist)
    if found:
        sys.exit("\n".join(found))
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "recipe.yaml"
    path.write_text(text, encoding="utf-8")
    recipe = rattler_build.Stage0Recipe.from_file(path)
    for platform in PLATFORMS:
        config = rattler_build.RenderConfig(
            platform=rattler_build.PlatformConfig(target_platform=platform)
        )
        variants = rattler_build.VariantConfig(VARIANTS)
        (variant,) = recipe.render(variants, config)
        print(f"{platform}: {variant.recipe.package.name} {variant.recipe.package.version}")


if __name__ == "__main__":
    main()
