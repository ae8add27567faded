"""The object tool: frames prepared in advance, and nested candidates for clicks."""

from pointbrush.work.objects.options import ObjectOptions
from pointbrush.work.objects.service import Answer, Clicks, Level, Objects, StaleCandidateError
from pointbrush.work.objects.stroke import ObjectStroke

__all__ = [
    "Answer",
    "Clicks",
    "Level",
    "ObjectOptions",
    "ObjectStroke",
    "Objects",
    "StaleCandidateError",
]
