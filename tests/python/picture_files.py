"""Files of pictures that Pillow does not write: OpenEXR, and XMP beside pixels."""

import struct
import zlib

import numpy as np
from PIL import Image

NAMESPACE = "http://ns.google.com/photos/1.0/panorama/"


def write_exr(path, pixels):
    """Linear RGB (height, width, 3) in single precision, not packed."""
    height, width = pixels.shape[:2]

    def attribute(name, kind, data):
        return f"{name}\0{kind}\0".encode() + struct.pack("<i", len(data)) + data

    channels = b"".join(
        name + b"\0" + struct.pack("<iBxxxii", 2, 0, 1, 1) for name in (b"B", b"G", b"R")
    )
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = struct.pack("<II", 0x01312F76, 2)
    head += attribute("channels", "chlist", channels + b"\0")
    head += attribute("compression", "compression", b"\0")
    head += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    head += attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", bytes(8))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    row = 8 + 12 * width
    first = len(head) + 8 * height
    offsets = b"".join(struct.pack("<Q", first + row * y) for y in range(height))
    rows = b"".join(
        struct.pack("<ii", y, 12 * width) + pixels[y, :, ::-1].T.astype("<f4").tobytes()
        for y in range(height)
    )
    path.write_bytes(head + offsets + rows)


def gpano_packet(said, *, as_elements=False, prefix="GPano"):
    """XMP that says so of a panorama: attributes, or elements as exiftool writes them."""
    attributes = inside = ""
    for name, value in said.items():
        if as_elements:
            inside += f"<{prefix}:{name}>{value}</{prefix}:{name}>\n"
        else:
            attributes += f' {prefix}:{name}="{value}"'
    return (
        '<?xpacket begin="" id="W5M0MpCehiHzreSzNTczkc9d"?><x:xmpmeta xmlns:x="adobe:ns:meta/">'
        '<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description '
        f'rdf:about="" xmlns:{prefix}="{NAMESPACE}"{attributes}>{inside}</rdf:Description>'
        "</rdf:RDF></x:xmpmeta>"
    ).encode()


def write_with_xmp(path, pixels, packet, *, is_packed=False):
    """A JPEG, PNG or WebP file with a packet of XMP beside the pixels (height, width, 3)."""
    image = Image.fromarray(np.asarray(pixels))
    if path.suffix != ".png":
        image.save(path, xmp=packet, quality=95)
        return
    image.save(path)
    data = path.read_bytes()
    text = zlib.compress(packet) if is_packed else packet
    block = b"XML:com.adobe.xmp\0" + (b"\1" if is_packed else b"\0") + b"\0\0\0" + text
    chunk = b"iTXt" + block
    whole = struct.pack(">I", len(block)) + chunk + struct.pack(">I", zlib.crc32(chunk))
    end_of_head = 8 + 25
    path.write_bytes(data[:end_of_head] + whole + data[end_of_head:])
