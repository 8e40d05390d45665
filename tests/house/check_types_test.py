#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The finder of types that are defined twice, on texts of its own."""
import unittest

from check_types import twice

ONE = "namespace a::b {\nstruct Place {\n  int x;\n};\nclass Known;\n}  // namespace a::b\n"
HIDDEN = "namespace a::b {\nnamespace {\nstruct Place {\n};\n}  // namespace\nstruct Whole::Place {\n};\n"
KINDS = ["class Place final : public Other<int> {", "enum class Place {", "struct Place { int x; };"]


class Types(unittest.TestCase):
    def test_one_namespace(self):
        self.assertEqual(twice({"1": ONE, "2": ONE}), {"a::b::Place": ["1", "2"]})
        for kind in KINDS:
            with self.subTest(kind):
                self.assertTrue(twice({"1": ONE, "2": ONE.replace("struct Place {", kind)}))

    def test_unnamed_and_other_namespaces(self):
        self.assertEqual(twice({"1": ONE, "2": HIDDEN}), {})
        self.assertEqual(twice({"1": ONE, "2": ONE.replace("a::b", "a")}), {})


if __name__ == "__main__":
    unittest.main()
