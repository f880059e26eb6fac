# Saves the first figure of a page whose title starts so as SVG, drawn by Chromium.
#
#     picture.sh PAGE TITLE PICTURE
set -eu
page=$1 title=$2 picture=$3 copy=${1%.html}.picture.html profile=$TARGET/chromium/$(basename "$3" .svg)
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome)
grep -q "<figcaption>$title" "$page" || { echo "$page has no figure “$title”" >&2; exit 1; }
{ cat "$page"; sed "s|TITLE|\"$title\"|" "$(dirname "$0")/picture.html"; } > "$copy"
# A profile of its own: a browser does not start while another one with its profile ends. Its own sandbox does not work
# for root; the page is ours.
"$browser" --headless --no-sandbox --disable-gpu --virtual-time-budget=20000 --dump-dom "--user-data-dir=$profile" \
    "file://$(realpath "$copy")" 2> /dev/null | tr '\n' '\001' | sed -n -e 's/.*<pre id="picture">\(.*\)<\/pre>.*/\1/' -e T \
    -e 's/&lt;/</g; s/&gt;/>/g; s/&nbsp;/\xc2\xa0/g; s/&amp;/\&/g; p' | tr '\001' '\n' > "$copy.svg"
echo >> "$copy.svg"
# What a process of the browser still holds is removed next time.
rm -rf "$profile" || true
grep -q '<svg' "$copy.svg" || { echo "Chromium drew no picture of $page" >&2; exit 1; }
mv "$copy.svg" "$picture"
