# SPDX-License-Identifier: Apache-2.0
"""check_words.py on small good and bad pages: python3 check_words_test.py."""
import unittest

import check_words as words


def lengths(text):
    return [len(s) for s in words.sentences(text)]


def links(text, pages):
    return [what for _, what in words.link_faults(text, "docs", lambda p: p in pages, lambda p: pages[p])]


def names(text, *files):
    return [what for _, what in words.name_faults(text, files)]


def commands(text):
    options = {"": {"--help", "--version"}, "train": {"--out", "--resume"}, "man": set()}
    return [what for _, what in words.command_faults(text, options)]


class Sentences(unittest.TestCase):
    def test_end_at_a_full_stop_a_question_mark_and_the_end_of_the_paragraph(self):
        self.assertEqual(lengths("One two. Three?\nfour five\n\nsix"), [2, 1, 2, 1])

    def test_may_begin_in_lower_case_and_close_with_brackets_or_emphasis(self):
        self.assertEqual(lengths('lego moves. (So does **trex.**) "It does." mutant too.'), [2, 3, 2, 2])

    def test_do_not_end_within_numbers_or_at_abbreviations_colons_and_semicolons(self):
        self.assertEqual(lengths("See Eq. 1 of 3.4.1, e.g. this: a; b"), [9])

    def test_count_code_as_one_word_and_of_links_the_text(self):
        self.assertEqual(lengths("Run `splinevox train DATA --out RUN` as [the page](a/b.md) says."), [6])

    def test_signs_alone_are_no_words(self):
        self.assertEqual(lengths("a + b - c"), [3])

    def test_items_of_a_list_are_paragraphs_and_their_lines_go_on(self):
        self.assertEqual(lengths("- one two\n  three\n- four\n1. five"), [3, 1, 1])

    def test_leave_out_tables_headings_pictures_comments_and_code(self):
        page = "# A heading\n\n| a | b |\n| - | - |\n![alt](x.png)\n<!-- a comment\nof two lines -->\n"
        page += "```\na code block\n```\n\n    indented code\n    more of it\n\nprose"
        self.assertEqual(lengths(page), [1])


class Links(unittest.TestCase):
    def test_to_what_is_there_are_no_fault(self):
        pages = {"docs/a.md": "# One, two: `three`\n", "README.md": ""}
        page = "[x](a.md#one-two-three) [y](../README.md) [z](https://a.b/c) [w](#here)\n# Here"
        self.assertEqual(links(page, pages), [])

    def test_to_what_is_not_there_are_named(self):
        pages = {"docs/a.md": "# One\n"}
        self.assertEqual(links("[x](b.md)", pages), ["there is no 'b.md'"])
        self.assertEqual(links("[x](a.md#two)", pages), ["'a.md#two' has no such heading"])
        self.assertEqual(links("[x](#one)", pages), ["'#one' has no such heading"])
        self.assertEqual(links("![picture](images/no.png)", pages), ["there is no 'images/no.png'"])

    def test_in_code_are_no_links(self):
        self.assertEqual(links("`a[0](b.md)`\n```\n[x](b.md)\n```", {}), [])

    def test_headings_of_one_name_are_numbered(self):
        self.assertEqual(words.headings("# A b\n## A b\n```\n# no\n```\n# A b"), ["a-b", "a-b-1", "a-b-2"])


class Names(unittest.TestCase):
    FILES = ("src/core/parallel.cpp", "include/splinevox/math/basis.hpp", "tests/train/discard_test.cpp",
             "src/data/read_a.cpp")

    def test_of_files_and_folders_with_and_without_an_ending_are_found(self):
        page = "`core/parallel` `math/basis.hpp` `basis.hpp` `src/core` `include/splinevox/math/`"
        self.assertEqual(names(page + " `train/discard` `parallel.cpp:12`", *self.FILES), [])

    def test_with_stars_and_braces_are_found(self):
        self.assertEqual(names("`data/read_*.cpp` `src/{core,data}`", *self.FILES), [])
        self.assertEqual(names("`data/write_*.cpp` `src/{core,dada}`", *self.FILES),
                         ["there is no file 'data/write_*.cpp'", "there is no file 'src/dada'"])

    def test_of_nothing_are_named(self):
        self.assertEqual(names("`core/serial` `asis.hpp` `math/basis.cpp`", *self.FILES),
                         [f"there is no file '{n}'" for n in ("core/serial", "asis.hpp", "math/basis.cpp")])

    def test_of_other_things_are_left_alone(self):
        page = "`metrics.json` `a/b` `runs/mutant` `report.html` `x / y` `train --out a.py`"
        self.assertEqual(names(page, *self.FILES), [])

    def test_in_code_blocks_are_left_alone(self):
        self.assertEqual(names("```\n`core/serial`\n```", *self.FILES), [])


class Commands(unittest.TestCase):
    def test_that_the_program_has_are_no_fault(self):
        page = "```\n# splinevox says --no\n"
        page += "mpirun -n 2 a/splinevox train DATA \\\n  --out=RUN --resume   # --no\n```\n"
        page += "`splinevox --version` `train --out R` `splinevox man | man -l --x` `splinevox VERB --option`"
        self.assertEqual(commands(page + " `make --jobs`"), [])

    def test_that_it_does_not_have_are_named(self):
        page = "```\nsplinevox train DATA --out RUN \\\n  --sped 2\n```"
        self.assertEqual(commands(page), ["splinevox train has no option '--sped'"])
        self.assertEqual(commands("`splinevox trail DATA`"), ["splinevox has no verb 'trail'"])
        self.assertEqual(commands("`train --loop`"), ["splinevox train has no option '--loop'"])
        self.assertEqual(commands("`splinevox --loop`"), ["splinevox has no option '--loop'"])

    def test_in_other_languages_are_left_alone(self):
        self.assertEqual(commands("```python\nimport splinevox as sv\n```"), [])


class Columns(unittest.TestCase):
    def test_are_counted_in_characters_and_the_limit_is_allowed(self):
        found = list(words.column_faults("ü" * 110 + "\n" + "x" * 111))
        self.assertEqual(found, [(2, "111 columns; the limit is 110")])


class PrivateWords(unittest.TestCase):
    def test_are_named_with_the_field_s_word_also_across_lines(self):
        text = "int a;  ///< no ray has\n        ///< shown it\n/// It comes to\n/// rest.\n"
        self.assertEqual(list(words.private_faults(text)),
                         [(1, "'ray has shown': the field says visible"),
                          (3, "'comes to rest': the field says static, or frozen")])
        for bad in ('f("PSNR of a held " "view")', "struct SeenMotion {", "// a still scene"):
            self.assertEqual(len(list(words.private_faults(bad))), 1, bad)

    def test_are_no_ordinary_english_and_no_keys(self):
        text = 'j["held_view"]; // the rest of the held-out views; told apart, shown, still there'
        self.assertEqual(list(words.private_faults(text)), [])


if __name__ == "__main__":
    unittest.main()
