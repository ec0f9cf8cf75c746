/* The C functions of CompoundRay's libEyeRenderer3, as Omma offers them under the old name: for its
 * Python scripts, which load libEyeRenderer3.so with ctypes, and for programs in C and C++.
 *
 * World frame: that of the glTF file. A camera has a position and a local space of three axes, its
 * right, its up and its forward; scaled axes scale what the camera sees with, an eye for instance.
 * Angles are in radians. Strings may be null and calls may come in any order: what cannot be done
 * says so on standard error and changes nothing. */
#ifndef OMMA_COMPAT_LIB_EYE_RENDERER_H
#define OMMA_COMPAT_LIB_EYE_RENDERER_H

#include <stdbool.h>
#include <stddef.h>

#ifndef __VECTOR_TYPES_H__ /* CUDA's header has the same struct */
typedef struct float3 {
  float x, y, z;
} float3;
#endif

/* An ommatidium of the eye at hand. The frame is that of .eye files: x right, y up, z forward. */
typedef struct OmmatidiumPacket {
  float posX, posY, posZ;
  float dirX, dirY, dirZ;
  float acceptanceAngle;  /* rad, full width at half maximum */
  float focalpointOffset; /* from the nodal point back along the axis */
} OmmatidiumPacket;

#ifdef __cplusplus
extern "C" {
#endif

/* --- Running. The environment variable OMMA_COMPAT_KERNEL, read by loadGlTFscene, is the angular
 * sensitivity: "compoundray" (where it is not set) or "gaussian". */
void setVerbosity(bool v); /* whether the lines that begin with [PyEye] are printed */
void loadGlTFscene(const char* filepath);
void stop(void); /* gives the scene's memory back; the frame and the cameras can still be read */
void setRenderSize(int w, int h);          /* of the frame, pixels; 400 x 400 at first */
double renderFrame(void);                  /* with new random samples; returns milliseconds */
void displayFrame(void);                   /* does nothing: there is no window */
void saveFrameAs(const char* ppmFilename); /* binary PPM, top row first */
/* RGBA bytes, bottom row first, [height][width][4]; good until setRenderSize. */
unsigned char* getFramePointer(void);
/* Copies the frame as RGB bytes, bottom row first, [height][width][3]. */
void getFrame(unsigned char* frame);

/* --- Cameras, in the order of the scene's nodes. Indices go round. */
size_t getCameraCount(void);
void nextCamera(void);
void previousCamera(void);
size_t getCurrentCameraIndex(void);
const char* getCurrentCameraName(void);
void gotoCamera(int index);
bool gotoCameraByName(const char* name); /* to the first camera, and false, where there is none */
void setCameraPosition(float x, float y, float z);
void getCameraPosition(float* x, float* y, float* z);
void setCameraLocalSpace(float lxx, float lxy, float lxz, float lyx, float lyy, float lyz,
                         float lzx, float lzy, float lzz); /* right, up, forward */
void rotateCameraAround(float angle, float axisX, float axisY, float axisZ);
void rotateCameraLocallyAround(float angle, float axisX, float axisY, float axisZ);
void translateCamera(float x, float y, float z);
void translateCameraLocally(float x, float y, float z);
void resetCameraPose(void); /* at the origin, right +x, up +y, forward +z */
/* Resets, turns about the world's x, y and z, then moves. */
void setCameraPose(float posX, float posY, float posZ, float rotX, float rotY, float rotZ);

/* --- Compound eyes. Without effect where the camera at hand is none. */
bool isCompoundEyeActive(void);
void setCurrentEyeSamplesPerOmmatidium(int s);      /* at least 1; 1 at first */
int getCurrentEyeSamplesPerOmmatidium(void);        /* -1 without an eye */
void changeCurrentEyeSamplesPerOmmatidiumBy(int s); /* adds */
size_t getCurrentEyeOmmatidialCount(void);          /* 0 without an eye */
void setOmmatidia(OmmatidiumPacket* omms, size_t count);
const char* getCurrentEyeDataPath(void); /* of the file that the eye came from */
void setCurrentEyeShaderName(const char* name);

/* --- Geometry by the name of its mesh. */
bool isInsideHitGeometry(float x, float y, float z, const char* name); /* of a hit box */
float3 getGeometryMaxBounds(const char* name); /* hit boxes first; 0, 0, 0 where there is none */
float3 getGeometryMinBounds(const char* name);

#ifdef __cplusplus
}
/* As CompoundRay declares it. */
inline void getCameraPosition(float& x, float& y, float& z) {
  getCameraPosition(&x, &y, &z);
}
#endif

/* Null: there is no window. Has, as in CompoundRay, C++ linkage in C++; the library has both. */
void* getWindowPointer(
#ifndef __cplusplus
    void
#endif
);

#endif
