"""`auto` without one of its ideas: options at which the idea never comes into effect."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from pointbrush.tracking.options import TrackerOptions

NEVER = 10**9
"""More than any count, size or ratio that occurs."""

IDEAS: dict[str, dict[str, dict[str, Any]]] = {
    # Where an object is
    "motion": {"search": {"remembered_poses": 1}},
    "other hypotheses": {"register": {"tries": 0, "tries_unknown_motion": 0}},
    "rest": {
        "register": {
            "rest_units": 0.0,
            "rest_units_first_scans": 0.0,
            "rest_units_moving_scanner": 0.0,
        }
    },
    "surface beside": {"register": {"excess_cost": 0.0}},
    "averted sides": {"register": {"averted_cost": 0.0}},
    "limit of motion before a lidar": {"register": {"beyond_cost": 0.0}},
    "claims lost to others": {"relocate": {"kept_share": 0.0}},
    "whole frame searched": {"relocate": {"doubt": float(NEVER)}},
    "voted shifts": {"propose": {"voted_shifts": 0}},
    "smoothing": {"smoothing": {"lag_frames": 0}},
    # Which points it has
    "hardly before the scene": {"background": {"faint_sigmas": 3.0}},
    "surveyed scene": {"background": {"survey_frames": 0}},
    "whole in the air": {"growth": {"max_steps": 0}},
    "colours of its own": {"appearance": {"rather_ratio": float(NEVER)}},
    "flying pixels": {
        "flying": {
            "min_pixels": NEVER,
            "level_units": float(NEVER),
            "outline_level_units": float(NEVER),
            "outline_behind_units": 0.0,
            "outline_few": 0,
        }
    },
    "unlabelled surface beside": {
        "context": {
            "max_points": 1,
            "explained_units": 0.0,
            "yield_ratio": 0.0,
            "stayed_units": 0.0,
        }
    },
    "space carving": {"surface": {"carve_min_views": NEVER}},
    "colours never shown": {"appearance": {"strange_share": -1.0}},
    "ground painted with it": {"ground_contact": {"min_points": NEVER}},
    "hidden by other colours": {"update": {"hiding_log_colour": float(NEVER)}},
    # What is learnt of it, and how far it is trusted
    "bending": {"track": {"bent_share": 1.0, "bent_share_large": 1.0}},
    "soft surface": {"track": {"soft_strain": float(NEVER)}},
    "rims behind outlines": {"strain": {"outline_offsets_px": (0, 0, 0)}},
    "exchanged tracks": {"identity": {"alike_radius_ratio": 0.0}},
    # People
    "people together": {"body": {"limb_m": 0.0}},
    "strides by depth": {"step": {"evidence_weight": 0.0}},
    "strides corrected": {"step": {"visible_doubt": float(NEVER)}},
    "clothes": {"step": {"clothes_weight": 0.0}},
    "clothes seen later": {"body": {"better_ratio": float(NEVER)}},
    "people without a label": {"arrivals": {"min_cells": NEVER}},
    "returning people": {"arrivals": {"back_min_cells": NEVER}},
    "exchanged people": {"arrivals": {"exchange_frames": NEVER}},
    "stature": {"stature": {"min_tops": NEVER}},
    # Sensors
    "a swaying camera at rest": {"sway": {"max_parallax": 0.0}},
    "way of a lidar": {"scan_odometry": {"rest_share": 0.0}},
    "shifts of the scenery": {"scan_odometry": {"shifts": 0}},
    "ground": {"ground": {"min_points": NEVER}},
    "range image": {"range_image": {"min_points": NEVER}},
    "rings": {"track": {"ring_share": 0.0}},
}
"""Idea -> group of options -> field -> value without the idea."""


def without(idea: str) -> TrackerOptions:
    """Return the options of ``auto`` without an idea of ``IDEAS``."""
    options = TrackerOptions()
    changed = {g: replace(getattr(options, g), **values) for g, values in IDEAS[idea].items()}
    return replace(options, **changed)
