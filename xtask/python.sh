# Builds the Python package as a wheel, installs it into the environment of PYTHON, and runs its tests. PROGRAM is the
# command line, built in the same profile.
set -eu
wheels=$TARGET/python/wheels
rm -rf "$wheels"
(cd python && "$PYTHON" -m maturin build --locked --profile dev --features of-workspace --out "$wheels") >&2
"$PYTHON" -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall "$wheels"/*.whl >&2
status=0
(cd python && "$PYTHON" -m mypy) || status=1
# Not in the folder of the package, whose source would go before the installed wheel.
cd python/tests
"$PYTHON" -m mypy.stubtest bearing_watch._core || status=1
BEARING_WATCH_PROGRAM=$PROGRAM "$PYTHON" -m pytest -rfEs -q -p no:cacheprovider || status=1
exit $status
