# The pictures of the book, one of each kind of plot, from traces that the workbench simulates: runs the commands of the
# chapter, saves figures of the pages that they write, and prints the block with the commands as it is.
set -eu
book=$PWD/book/src picture=$PWD/xtask/docs/picture.sh folder=$TARGET/book-pages
block=$(sed -n '/^<!-- generated: cargo xtask docs book -->/,/^<!-- end -->/p' "$book/plots.md" | grep -v '^<!--')
cargo build --release --quiet --package bearing-watch-workbench
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
export PATH="$TARGET/release:$PATH"
# An audit that has found something ends with 1.
eval "$(printf '%s\n' "$block" | grep -v '^```' | sed 's/audit\.html$/& || [ $? = 1 ]/')" >&2
# Page, picture, and start of the figure's title.
while read -r page name title; do
    sh "$picture" "$page.html" "$title" "$book/pictures/$name.svg"
done <<'END'
audit signals Signals
audit orders Amplitude of the current
structure fit Free-run fit on the validation traces
validate free-run Output from the inputs alone
validate independence Cross-correlation of the residuals
validate whiteness Autocorrelation of the residuals
validate poles Poles and zeros
validate frequency Frequency response from u2
train distribution Distribution of a1
train regions Features in the plane
train runs Features over runs
train posteriors Posterior of each segment
train reliability Posteriors beside what came true
replay verdicts Signals and verdicts
replay evidence Distance and evidence
END
# The traces take tens of megabytes.
rm -r "$folder"
printf '%s\n' "$block"
