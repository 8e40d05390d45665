#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds statements that are chained by commas (`a = 1, b = 2;`); with --fix writes one statement for each.

check_commas.py [--fix] FILE...    exit code 1 if there are any (without --fix)
"""
import re
import sys

TOKEN = re.compile(
    r'R"(?P<tag>[^ ()\\\t\n]*)\((?:.|\n)*?\)(?P=tag)"'  # raw strings
    r'|"(?:\\.|[^"\\\n])*"|//[^\n]*(?:\\\n[^\n]*)*|/\*(?:.|\n)*?\*/'
    r"|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'|[A-Za-z_]\w*|\d[\w.']*|\s+"
    r"|->|<<=|>>=|[-+*/%&|^]=|\+\+|--|==|!=|<=|>=|&&|\|\||::|.")
DIRECTIVE = re.compile(r"[ \t]*#(?:[^\n\\]|\\\n|\\.)*")
ASSIGN = {"=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>="}
CONTROL = {"if", "for", "while", "switch", "constexpr"}
LABELS = {"default", "public", "private", "protected"}
NO_STATEMENT = {"using", "typedef", "template", "friend", "namespace", "enum", "struct", "class", "case",
                "static", "const", "constexpr", "auto", "inline", "extern", "throw", "goto"}
CLOSE = {"(": ")", "[": "]", "{": "}"}


def tokens_of(text):
    at, out = 0, []
    line_start = True
    while at < len(text):
        if line_start and (m := DIRECTIVE.match(text, at)):
            out.append((m.group(), at, "space"))
            at, line_start = m.end(), False
            continue
        m = TOKEN.match(text, at)
        t = m.group()
        kind = "space" if t.isspace() or t.startswith(("//", "/*")) else "code"
        out.append((t, at, kind))
        line_start = t.endswith("\n") or (line_start and t.isspace())
        at = m.end()
    return out


def chains(text):
    """(start, ends of the parts, end, controlled, returns) of every chain, as offsets."""
    toks = [(t, at) for t, at, kind in tokens_of(text) if kind == "code"]
    match, stack = {}, []
    for i, (t, at) in enumerate(toks):
        # Template arguments follow their name at once; a comparison has a space before it.
        if t == "<" and i > 0 and toks[i - 1][1] + len(toks[i - 1][0]) == at and toks[i - 1][0] != "operator":
            stack.append(i)
        elif t == ">" and stack and toks[stack[-1]][0] == "<":
            o = stack.pop()
            match[o], match[i] = i, o
        elif t in CLOSE:
            stack.append(i)
        elif t in (")", "]", "}") and stack:
            while len(stack) > 1 and toks[stack[-1]][0] == "<":  # a comparison after all
                stack.pop()
            o = stack.pop()
            match[o], match[i] = i, o
    found = []

    def begins(i):
        """Whether a statement may begin at token i, and whether it hangs on a control."""
        if i == 0:
            return True, False
        p = toks[i - 1][0]
        if p == "}" and initialises(match.get(i - 1)):
            return False, False
        if p in (";", "{", "}"):
            return True, False
        if p in ("else", "do"):
            return True, True
        if p == ")" and (o := match.get(i - 1)) is not None and o > 0 and toks[o - 1][0] in CONTROL:
            return True, True
        if p == ":" and i > 1 and (toks[i - 2][0] in LABELS or in_case(i - 1)):
            return True, False
        return False, False

    def initialises(o):
        """Whether the brace at token o begins a list of values and no block."""
        if o is None or o == 0:
            return False
        before = toks[o - 1][0]
        block = ("else", "do", "try", "const", "noexcept", "override", "final")
        if before in (">", ",", "(", "=", "return"):
            return True
        return bool(re.match(r"[A-Za-z_]\w*$", before)) and before not in block

    def in_case(i):
        j = i - 1
        while j >= 0 and toks[j][0] not in (";", "{", "}", ":"):
            if toks[j][0] == "case":
                return True
            j -= 1
        return False

    for i in range(len(toks)):
        ok, controlled = begins(i)
        if not ok or toks[i][0] in CONTROL or toks[i][0] in ("{", "}", ";", "else", "do"):
            continue
        parts, start, j = [], i, i
        while j < len(toks) and toks[j][0] not in (";", "}", ")", "]"):
            if toks[j][0] in CLOSE or (toks[j][0] == "<" and j in match):
                j = match.get(j, len(toks))
            elif toks[j][0] == ",":
                parts.append((start, j))
                start = j + 1
            j += 1
        if any(toks[k][0] == "<<" and toks[k + 1][0] == "<" for k in range(i, min(j, len(toks) - 1))):
            continue  # a launch of CUDA
        if not parts or j >= len(toks) or toks[j][0] != ";":
            continue
        returns = toks[i][0] == "return"
        first = (i + 1 if returns else i, parts[0][1])
        if not expression(toks, match, *first):
            continue
        parts.append((start, j))
        spans = [(toks[a][1], toks[b][1]) for a, b in parts]
        found.append((toks[i][1], spans, toks[j][1], controlled, returns))
    return found


def expression(toks, match, a, b):
    """Whether tokens a..b are an assignment, a call, or ++x: no declaration and no list."""
    j, before, operator = a, None, None
    words = 0  # names in a row without an operator between them: a declaration
    while j < b:
        t = toks[j][0]
        if t in ASSIGN:
            operator = t
            break
        name = bool(re.match(r"[A-Za-z_]\w*$", t))
        if name and before and (re.match(r"[A-Za-z_]\w*$", before) or before in (">", "&", "*") and words):
            return False  # `float x`, `const T& x`, `vector<T> x`
        if name and before in (None, "*", "(") or name:
            words += 1
        if t in CLOSE or (t == "<" and j in match):
            j = match[j]
            t = toks[j][0]
        before = t
        j += 1
    if toks[a][0] in NO_STATEMENT:
        return False
    depth0 = [toks[i][0] for i in range(a, j)]
    if ":" in depth0 and "?" not in depth0:
        return False  # a constructor and its members' first values
    if operator:
        return True
    last = toks[b - 1][0]
    return last == ")" or last in ("++", "--") or toks[a][0] in ("++", "--")


def main(arguments):
    fix = "--fix" in arguments
    bad = 0
    for path in [a for a in arguments if a != "--fix"]:
        with open(path, encoding="utf-8") as file:
            text = file.read()
        found = chains(text)
        bad += len(found)
        if fix:
            while chains(text):
                text = fixed_once(text)
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        else:
            for start, *_ in found:
                line = text.count("\n", 0, start) + 1
                shown = text[start:text.find("\n", start)].strip()
                print(f"{path}:{line}: statements chained by commas: {shown}")
    return 0 if fix or bad == 0 else 1


def fixed_once(text):
    """The innermost chain last in the text, written as statements of their own."""
    start, parts, end, controlled, returns = max(chains(text))
    pieces = [text[a:b].strip() for a, b in parts]
    if returns:
        pieces[0] = pieces[0][len("return"):].strip()
        pieces[-1] = "return " + pieces[-1]
    body = " ".join(p + ";" for p in pieces)
    return text[:start] + ("{ " + body + " }" if controlled else body) + text[end + 1:]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
