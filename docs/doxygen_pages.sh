#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Doxygen's filter (FILTER_PATTERNS in Doxyfile): a page is known by its file's name, and what names or links
# the file leads to the page.
case $1 in
  */docs/*.md | docs/*.md) title="1s/^# .*/& {#page_$(basename "$1" .md)}/" ;;
  *) title='' ;;
esac
sed -E "$title
  s,\]\((\.\./)?README\.md\),](@ref index),g
  s,\]\((\.\./)?([a-z0-9_]+/)*([a-z0-9_]+)\.md(#[^)]*)?\),](@ref page_\3),g
  s,(^|[ (])docs/(([a-z0-9_]+/)*)([a-z0-9_]+)\.md,\1[docs/\2\4.md](@ref page_\4),g" "$1"
