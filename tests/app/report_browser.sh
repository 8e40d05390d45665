#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A report in a headless browser: nothing on the console, every chart drawn, nothing fetched. Skipped (77)
# where there is no Chromium.
#   report_browser.sh SPLINEVOX FOLDER
set -euo pipefail
splinevox=$1 folder=$2
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
[[ -n $browser ]] || { echo "skipped: there is no Chromium here (apt-get install chromium)"; exit 77; }

rm -rf "$folder" && mkdir -p "$folder"
"$splinevox" synth ball --out "$folder/scene" --size 32 --frames 12 > /dev/null
"$splinevox" train "$folder/scene" --out "$folder/run" --preset draft --max-steps 40 --quiet
"$splinevox" eval "$folder/run" > /dev/null
"$splinevox" report "$folder/run" --out "$folder/report.html" > /dev/null

# The page as it is, and behind it a script that writes down how many dots each chart has drawn and what was
# fetched.
{ cat "$folder/report.html"
  cat <<'END'
<script>
const drawn = [...document.querySelectorAll("canvas")].map(c => {
  const pixels = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
  let count = 0;
  for (let i = 3; i < pixels.length; i += 4) count += pixels[i] > 0;
  return count;
});
document.body.dataset.drawn = drawn.join(" ");
const fetched = performance.getEntriesByType("resource").filter(r => !r.name.startsWith("data:"));
document.body.dataset.fetched = fetched.length;
</script>
END
} > "$folder/checked.html"
timeout 120 "$browser" --headless=new --no-sandbox --disable-gpu --enable-logging=stderr \
  --window-size=1200,1800 --user-data-dir="$folder/profile" --virtual-time-budget=5000 \
  --dump-dom "file://$(realpath "$folder/checked.html")" > "$folder/dom.html" 2> "$folder/log"
if grep "CONSOLE" "$folder/log"; then echo "failed: the browser's console is not empty"; exit 1; fi
drawn=$(grep -o 'data-drawn="[^"]*"' "$folder/dom.html" | cut -d'"' -f2)
fetched=$(grep -o 'data-fetched="[^"]*"' "$folder/dom.html" | cut -d'"' -f2)
echo "dots drawn per chart: $drawn; files fetched: $fetched"
[[ $fetched == 0 ]] || { echo "failed: the page fetches files"; exit 1; }
[[ $(wc -w <<< "$drawn") == 3 ]] || { echo "failed: a page with three charts was expected"; exit 1; }
for count in $drawn; do ((count > 500)) || { echo "failed: a chart is empty"; exit 1; }; done
