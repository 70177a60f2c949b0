"""The shortest way to a picture: silk on the built-in cloth under a built-in sky.

python examples/01_first_picture.py [out/01_first_picture.png]
"""

import sys

from common import output

import glcloth

path = output(sys.argv[1] if len(sys.argv) > 1 else "out/01_first_picture.png")
with glcloth.Renderer() as renderer:
    picture = renderer.render(fabric="silk_crepe_de_chine", environment="sky", size=(640, 480))
glcloth.write_image(path, picture)
print(path)
