#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The finder of chained statements, on snippets of its own."""
import unittest

from check_commas import chains, fixed_once

CHAINS = {
    "{ a = 1, b = 2; }": "{ a = 1; b = 2; }",
    "if (x) a.b = 1, c[i, j] = 2;": "if (x) { a.b = 1; c[i, j] = 2; }",
    "{ return out.note = \"x, y\", out; }": "{ out.note = \"x, y\"; return out; }",
    "{ ++n, f(a, b); }": "{ ++n; f(a, b); }",
    "for (int i = 0, j = 1; i < n; ++i, --j) p[i] = 0, q[j] = 1;":
        "for (int i = 0, j = 1; i < n; ++i, --j) { p[i] = 0; q[j] = 1; }",
}
NONE = [
    "{ int a = 1, b = 2; }",
    "{ const Vec3d c = Vec3d{1, 2, 3} - 0.5 * d, half = 0.5 * d; }",
    "{ x = shade<Sh, Moving>(a, b); }",
    "{ kernel<<<blocks, 256, 0, stream>>>(n, k); }",
    "struct S { S(int a, int b) : a_(a), b_(b) {} int a_, b_; };",
    "enum class Kind { one, two };",
    "{ f([&] { return g(a, b); }, c); }",
    "template <class T, int N> void f(T a, int b);",
    "// a = 1, b = 2;\n",
]


class Commas(unittest.TestCase):
    def test_chains_become_statements(self):
        for text, wanted in CHAINS.items():
            with self.subTest(text):
                self.assertEqual(len(chains(text)), 1)
                self.assertEqual(fixed_once(text), wanted)
                self.assertEqual(chains(wanted), [])

    def test_lists_are_left_alone(self):
        for text in NONE:
            with self.subTest(text):
                self.assertEqual(chains(text), [])


if __name__ == "__main__":
    unittest.main()
