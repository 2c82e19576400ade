"""The scenes of the comparison. A further one is a line here and settings in the contestants."""

from . import equation8, shell, shock

SCENES = {module.SCENE.name: module.SCENE for module in (equation8, shell, shock)}
