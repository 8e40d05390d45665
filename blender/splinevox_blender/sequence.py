# SPDX-License-Identifier: Apache-2.0
"""What an export holds, from the head of the script beside its frames. The script is read and not run: a
folder that somebody sent is no reason to run what is in it."""
import ast
import os

from .load_in_blender import Sequence

SCRIPT = "load_in_blender.py"
FACTS = {"FPS": "fps", "VELOCITY": "velocity", "LINEAR": "linear", "PREFIXES": "prefixes",
         "SH_ORDER": "sh_order"}


def is_run(folder):
    return os.path.isfile(os.path.join(folder, "config.toml"))


def is_export(folder):
    return os.path.isfile(os.path.join(folder, SCRIPT))


def read_sequence(folder):
    """@return the Sequence of an export with the profile blender. Throws ValueError saying what is wrong."""
    path = os.path.join(folder, SCRIPT)
    try:
        with open(path, encoding="utf-8") as f:
            body = ast.parse(f.read()).body
    except FileNotFoundError:
        raise ValueError("%s: there is no %s. Expected: what `splinevox export --profile blender` wrote"
                         % (folder, SCRIPT)) from None
    except (OSError, SyntaxError, UnicodeDecodeError) as e:
        raise ValueError("%s cannot be read: %s" % (path, e)) from None
    found = {"folder": folder}
    for statement in body:
        if not isinstance(statement, ast.Assign):
            continue
        names = [getattr(n, "id", "") for n in getattr(statement.targets[0], "elts", statement.targets)]
        if names == ["FIRST", "LAST"]:
            found["first"], found["last"] = ast.literal_eval(statement.value)
        elif names[0] in FACTS:
            found[FACTS[names[0]]] = ast.literal_eval(statement.value)
    missing = [name for name in Sequence._fields if name not in found]
    if missing:
        raise ValueError("%s does not say %s. Expected: the script that this version of splinevox writes"
                         % (path, ", ".join(missing)))
    return Sequence(**found)
