# Makes an empty virtual environment of Python in FOLDER; DEBIAN is the folder of unpacked packages.
set -eu
folder=$1
if python3 -c 'import ensurepip' 2> /dev/null; then
    exec python3 -m venv --clear "$folder"
fi
# Python's own installer is missing, and the unpacked one is not at the place where Python looks for it.
wheel=$(ls "$DEBIAN"/pip/usr/share/python-wheels/pip-*.whl)
python3 -m venv --clear --without-pip "$folder"
if [ -e "$DEBIAN/bin/python3" ]; then
    # An unpacked Python finds its libraries by a script: of the names in the environment the one that is used.
    rm "$folder/bin/python"
    sed "s|^exec .*|exec '$folder/bin/python3' \"\$@\"|" "$DEBIAN/bin/python3" > "$folder/bin/python"
    chmod +x "$folder/bin/python"
fi
PYTHONPATH=$wheel "$folder/bin/python" -m pip install --quiet --no-index "$wheel"
