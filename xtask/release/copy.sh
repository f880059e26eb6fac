# For programs that write beside manifests, or whose results other packages would change: a copy of the tree in a folder
# of the target directory, whose workspace has other members besides the package of its root.
copy() {
    copied=$TARGET/$1/source
    rm -rf "$copied"
    mkdir -p "$copied"
    git ls-files -z --cached --others --exclude-standard | tar --null --files-from=- -cf - | tar -xf - -C "$copied"
}

# set_members FOLDER…
set_members() {
    list=$(for folder in "$@"; do [ "$folder" = ./ ] || printf '"%s", ' "$folder"; done)
    sed -i "s|^members = .*|members = [$list]|; s|^default-members = .*|default-members = [\".\"]|" "$copied/Cargo.toml"
    # The versions of the tree, of which the members before may have kept some only.
    cp Cargo.lock "$copied"
}
