"""Landmarks of the reference face: a row has the parameters of its modes, in millimetres.

The face is stored as face.safetensors, and articulation and retargeting carry its motion to any rig.
"""

from phonanim.face.model import FaceModel

TARGET = FaceModel
