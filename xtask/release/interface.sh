# The public interface of the core beside that of the revision BASELINE: what breaks programs of users needs another
# version. The libraries of the workbench serve its command line and the Python package.
set -eu
if [ -z "${BASELINE-}" ]; then
    echo "there is no release yet (no tag v…): nothing to compare with"
    exit 78
fi
"$TOOL" semver-checks --package bearing-watch --baseline-rev "$BASELINE"
