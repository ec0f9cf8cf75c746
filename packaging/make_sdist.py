"""Makes the source distribution in a folder, and says where: python packaging/make_sdist.py OUT

From a copy of what git knows or would take: scikit-build-core looks into every folder before
it leaves out what is ignored, and build/ may hold roots of whole systems. Without git, as in what
was unpacked from a source distribution, everything is taken.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from scikit_build_core.build import build_sdist

ROOT = Path(__file__).resolve().parents[1]


def main() -> None:
    out = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as tree:
        listed = None
        if (ROOT / ".git").exists():
            listing = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
            listed = subprocess.run(listing, cwd=ROOT, capture_output=True, text=True, check=True)
        if listed is None:
            os.chdir(ROOT)
        else:
            for name in filter(None, listed.stdout.split("\0")):
                if (ROOT / name).is_file():  # and not deleted since
                    (Path(tree) / name).parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy2(ROOT / name, Path(tree) / name)
            os.chdir(tree)
        print(out / build_sdist(str(out)))
        os.chdir(ROOT)


if __name__ == "__main__":
    main()
