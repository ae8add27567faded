"""The options of pointbrush, each defined once.

``definitions`` defines an option, ``settings`` has all options, ``command_sets`` the commands that
take them.
"""

from pointbrush.settings.settings import Settings

__all__ = ["Settings"]
