"""The scenes of the comparison. A further one is a line here and settings in the contestants."""

from . import equation8, shell, shock, smile, zodi

SCENES = {module.SCENE.name: module.SCENE for module in (equation8, shell, shock, smile, zodi)}

#: The scenes of the table of what users would pick.
USERS = ("eq8", "smile", "zodi")
