# SPDX-License-Identifier: Apache-2.0
"""__init__.pyi says what the module has: names, parameters in order, and which of them may be left out."""
import ast
import inspect
import pathlib
import re

import splinevox as sv

TREE = ast.parse(pathlib.Path(sv.__file__).with_suffix(".pyi").read_text())


def parameters_of_stub(function):
    names = [a.arg for a in function.args.args]
    return names, len(function.args.defaults)


def parameters_of_module(function):
    """From the first line of what pybind11 writes: name(a: type, b: type = default) -> type."""
    line = function.__doc__.split("\n")[0]
    inside = re.match(r"\w+\((.*)\) -> ", line).group(1)
    parts, depth, word, quoted = [], 0, "", False
    for c in inside:
        quoted ^= c == "'"
        depth += (c in "[({<") - (c in "])}>")
        if c == "," and depth == 0 and not quoted:
            parts.append(word)
            word = ""
        else:
            word += c
    parts += [word] if word.strip() else []
    return [p.split(":")[0].strip() for p in parts], sum(" = " in p for p in parts)


def public(names):
    return {n for n in names if not n.startswith("_")}


def test_the_stub_has_every_name_and_no_other():
    stub = {n.name for n in TREE.body if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
    assert stub == {n for n in public(vars(sv)) if not inspect.ismodule(getattr(sv, n))}


def test_functions_take_what_the_stub_says():
    for node in TREE.body:
        if isinstance(node, ast.FunctionDef):
            assert parameters_of_stub(node) == parameters_of_module(getattr(sv, node.name)), node.name


def test_classes_have_what_the_stub_says():
    for node in TREE.body:
        if not isinstance(node, ast.ClassDef) or node.name.endswith("Error"):
            continue
        kind = getattr(sv, node.name)
        methods = {m.name: m for m in node.body if isinstance(m, ast.FunctionDef)}
        assert public(methods) == public(vars(kind)), node.name
        for name, method in methods.items():
            member = vars(kind)[name]
            is_property = bool(method.decorator_list)
            assert is_property == isinstance(member, property), (node.name, name)
            if not is_property:
                assert parameters_of_stub(method) == parameters_of_module(member), (node.name, name)


def test_everything_is_documented():
    for name in public(vars(sv)):
        thing = getattr(sv, name)
        if inspect.ismodule(thing):
            continue
        assert thing.__doc__ and thing.__doc__.strip(), name
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            for member in public(vars(thing)):
                assert vars(thing)[member].__doc__.strip(), (name, member)
