# Bills of materials (CycloneDX): the packages that each published crate is built from; of the core with all features.
# The wheel contains its own, which maturin writes.
set -eu
. xtask/release/copy.sh
rm -f "$DIST"/*.cdx.json
copy sbom
for own in $PUBLISHED; do
    name=${own%%:*} folder=${own#*:} all=
    # In a workspace of this package alone: others would turn on more features of what both use.
    set_members "$folder"
    [ "$folder" != ./ ] || all=--all-features
    stem=$name-$VERSION
    (cd "$copied" && "$TOOL" cyclonedx --format json --spec-version 1.5 --target all --no-build-deps \
        --override-filename "$stem" $all --manifest-path "$folder/Cargo.toml")
    # References contain the place of the copy.
    sed "s|$copied|/bearing-watch|g" "$copied/$folder/$stem.json" > "$DIST/$stem.cdx.json"
    grep -q '"purl"' "$DIST/$stem.cdx.json"
done
