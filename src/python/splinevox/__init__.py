# SPDX-License-Identifier: Apache-2.0
"""Moving scenes as sparse voxel volumes whose motion is a spline.

    import splinevox as sv
    data = sv.load_dataset("data/mutant", downscale=2)
    model = sv.train(data, sv.Config(max_time=60))
    picture = model.render(data.frames("test")[0].camera, time=0.5).rgb

Arrays are numpy's. What goes wrong is a splinevox.Error with the message of the command line. See
docs/python.md.
"""
from ._core import *  # noqa: F401,F403
from ._core import __version__  # noqa: F401
