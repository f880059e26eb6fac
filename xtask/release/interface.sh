# The public interface of the core beside that of the revision BASELINE, or of the newest tag of a release: what breaks
# programs of users needs another version. The libraries of the workbench serve its command line and the Python package.
set -eu
revision=${BASELINE:-$(git describe --tags --abbrev=0 --match 'v[0-9]*' 2> /dev/null)} || {
    echo "there is no release yet (no tag v…): nothing to compare with"
    exit 78
}
"$TOOL" semver-checks --package bearing-watch --baseline-rev "$revision"
