// Images from encoded bytes, for readers of other formats: what an image claims can be asked before
// it is decoded.
#pragma once

#include "io/image_formats.h"

namespace omma {

// What the header claims, checked: at least one pixel, no more than are read of any image, and no
// more than the encoded bytes can hold. Throws omma::Error that starts with `place`.
ImageClaim image_claim(EncodedImage bytes, const std::string& place);

// Bytes of memory that images of so many encoded bytes may take: one of the largest size is always
// read, and well-packed ones beyond; too little for a file made to exhaust the memory.
std::uint64_t image_budget(std::uint64_t encoded_bytes);

// sRGB code value in [0, 1] of linear light (IEC 61966-2-1).
double srgb_from_linear(double linear);

// As decode_image of omma/io.h, watched; without a limit of memory, which is the caller's.
Image decode_claimed_image(EncodedImage bytes, const std::string& place, const WorkPart& work);

}  // namespace omma
