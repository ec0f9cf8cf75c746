"""Pictures: of responses, in twelve projections; of eyes, as drawings, maps and posters.
`omma.render_camera` makes those of what cameras see.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
