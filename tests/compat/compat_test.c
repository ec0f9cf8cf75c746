/* CompoundRay's library from C: every function, in the orders in which programs call them. The
 * scene is room.gltf, a room of six walls around the origin, red at +x, green at -x, blue at +y,
 * yellow at -y, cyan at +z, grey at -z; six.eye looks at one of them with each of its ommatidia.
 * Run as `compat_test FOLDER`, the folder with these files. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "libEyeRenderer.h"

static int failures = 0;

#define CHECK(condition)                                             \
  do {                                                               \
    if (!(condition)) {                                              \
      printf("%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
      ++failures;                                                    \
    }                                                                \
  } while (0)

/* trunc(255 * 0.5^(1/2.2)), the display value of the grey wall. */
enum { GREY = 186 };

static const float PI = 3.14159265358979f;

static bool shows(const unsigned char* pixel, int r, int g, int b) {
  return pixel[0] == r && pixel[1] == g && pixel[2] == b && pixel[3] == 255;
}

static uint32_t id_at(const unsigned char* pixel) {
  return (uint32_t)pixel[0] << 24 | (uint32_t)pixel[1] << 16 | (uint32_t)pixel[2] << 8 | pixel[3];
}

static bool is_at(float x, float y, float z) {
  float p[3] = {NAN, NAN, NAN};
  getCameraPosition(&p[0], &p[1], &p[2]);
  /* Float arithmetic of a few steps on coordinates of size 10. */
  return fabsf(p[0] - x) < 1e-5f && fabsf(p[1] - y) < 1e-5f && fabsf(p[2] - z) < 1e-5f;
}

/* Before there is a scene nothing may crash. */
static void without_a_scene(void) {
  unsigned char* frame = getFramePointer();
  CHECK(frame != NULL);
  CHECK(getCameraCount() == 0);
  CHECK(!isCompoundEyeActive());
  CHECK(getCurrentEyeSamplesPerOmmatidium() == -1);
  CHECK(getCurrentEyeOmmatidialCount() == 0);
  CHECK(strcmp(getCurrentEyeDataPath(), "") == 0);
  renderFrame();
  nextCamera();
  previousCamera();
  gotoCamera(3);
  CHECK(!gotoCameraByName("front"));
  CHECK(strcmp(getCurrentCameraName(), "Default Camera") == 0);
  CHECK(getCameraCount() == 1);
  setCameraPosition(1, 2, 3);
  CHECK(is_at(1, 2, 3));
  CHECK(!isInsideHitGeometry(0, 0, 0, "box"));
  CHECK(getGeometryMaxBounds("box").x == 0);
  displayFrame();
  loadGlTFscene("no-such-file.gltf");
  loadGlTFscene(NULL);
  saveFrameAs(NULL);
  getFrame(NULL);
  setOmmatidia(NULL, 0);
  setCurrentEyeShaderName(NULL);
  CHECK(getWindowPointer() == NULL);
}

static void cameras(void) {
  /* Roots by index, children below them; the eye without a file is left out. */
  const char* names[] = {"nested", "front", "insect", "panorama", "map", "vector"};
  CHECK(getCameraCount() == 6);
  for (size_t i = 0; i < 6; ++i) {
    CHECK(getCurrentCameraIndex() == i);
    CHECK(strcmp(getCurrentCameraName(), names[i]) == 0);
    CHECK(isCompoundEyeActive() == (i == 2 || i == 5));
    nextCamera();
  }
  CHECK(getCurrentCameraIndex() == 0); /* round */
  previousCamera();
  CHECK(getCurrentCameraIndex() == 5);
  gotoCamera(-1);
  CHECK(getCurrentCameraIndex() == 5);
  gotoCamera(8);
  CHECK(getCurrentCameraIndex() == 2);
  CHECK(gotoCameraByName("panorama"));
  CHECK(getCurrentCameraIndex() == 3);
  CHECK(!gotoCameraByName("lost"));
  CHECK(getCurrentCameraIndex() == 0);
  CHECK(!gotoCameraByName(NULL));
  CHECK(is_at(0, 3, 0)); /* the nested camera, 2 above its parent, which is 1 above the ground */
}

static void pictures(const char* ppm) {
  const int w = 6, h = 4;
  setRenderSize(w, h);
  gotoCameraByName("front");
  CHECK(renderFrame() > 0);
  unsigned char* frame = getFramePointer();
  for (int i = 0; i < w * h; ++i) /* 90 degrees of view: the wall ahead, but for its border */
    CHECK(i % w == 0 || i < w || shows(frame + 4 * i, GREY, GREY, GREY));

  /* Pitched up by 45 degrees: blue ceiling in the upper half. Row 0 is the bottom one. */
  rotateCameraLocallyAround(PI / 4 + 0.01f, 1, 0, 0);
  renderFrame();
  CHECK(shows(frame + 4 * (0 * w + 3), GREY, GREY, GREY));
  CHECK(shows(frame + 4 * (3 * w + 3), 0, 0, 255));
  unsigned char rgb[6 * 4 * 3];
  getFrame(rgb);
  for (int i = 0; i < w * h; ++i) CHECK(memcmp(rgb + 3 * i, frame + 4 * i, 3) == 0);

  saveFrameAs(ppm);
  FILE* file = fopen(ppm, "rb");
  CHECK(file != NULL);
  if (file != NULL) {
    unsigned char bytes[200];
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    const char* header = "P6\n6 4\n255\n";
    const size_t start = strlen(header);
    CHECK(size == start + 6 * 4 * 3);
    CHECK(memcmp(bytes, header, start) == 0);
    CHECK(memcmp(bytes + start, rgb + 3 * w * (h - 1), (size_t)(3 * w)) == 0); /* top row first */
  }
  remove(ppm);
  saveFrameAs("frame.png"); /* must be a ppm */
  CHECK(fopen("frame.png", "rb") == NULL);
  saveFrameAs("no/such/folder/frame.ppm");

  setRenderSize(0, -3);
  renderFrame();
  CHECK(getFramePointer() != NULL);
}

static void poses(void) {
  setRenderSize(3, 3);
  gotoCameraByName("front");
  resetCameraPose(); /* now towards +z */
  CHECK(is_at(0, 0, 0));
  renderFrame();
  unsigned char* middle = getFramePointer() + 4 * 4;
  CHECK(shows(middle, 0, 255, 255));
  rotateCameraAround(PI / 2, 0, 2, 0); /* from +z to +x; the axis need not be a unit vector */
  renderFrame();
  CHECK(shows(middle, 255, 0, 0));
  translateCamera(1, 2, 3);
  translateCameraLocally(0, 0, 2); /* two ahead, to +x */
  CHECK(is_at(3, 2, 3));
  setCameraLocalSpace(1, 0, 0, 0, 0, 1, 0, -1, 0); /* looks at -y */
  renderFrame();
  CHECK(shows(middle, 255, 255, 0));
  /* Forward (0,0,1) turns about x by -90 degrees to +y, which turning about y leaves there; about
   * z by 90 degrees it goes to -x. */
  setCameraPose(1, 0, 0, -PI / 2, 1, PI / 2);
  CHECK(is_at(1, 0, 0));
  renderFrame();
  CHECK(shows(middle, 0, 255, 0));
  rotateCameraAround(1, 0, 0, 0);                 /* no axis: stays */
  setCameraLocalSpace(0, 0, 0, 0, 0, 0, 0, 0, 0); /* no space: the frame stays */
  CHECK(renderFrame() >= 0);
  CHECK(shows(middle, 0, 255, 0));
  setCameraLocalSpace(NAN, 0, 0, 0, 1, 0, 0, 0, 1);
  renderFrame();
  setCameraPose(0, 0, 0, 0, 0, 0);
  renderFrame();
  CHECK(shows(middle, 0, 255, 255));
}

static void eyes(void) {
  CHECK(gotoCameraByName("insect"));
  CHECK(is_at(1, 2, 3));
  CHECK(getCurrentEyeOmmatidialCount() == 6);
  const char* path = getCurrentEyeDataPath();
  CHECK(strlen(path) > 7 && strcmp(path + strlen(path) - 7, "six.eye") == 0);
  CHECK(getCurrentEyeSamplesPerOmmatidium() == 1);
  setCurrentEyeSamplesPerOmmatidium(20);
  changeCurrentEyeSamplesPerOmmatidiumBy(-5);
  CHECK(getCurrentEyeSamplesPerOmmatidium() == 15);
  changeCurrentEyeSamplesPerOmmatidiumBy(-100);
  CHECK(getCurrentEyeSamplesPerOmmatidium() == 1);
  setCurrentEyeSamplesPerOmmatidium(0);
  CHECK(getCurrentEyeSamplesPerOmmatidium() == 1);
  setCurrentEyeSamplesPerOmmatidium(8);

  setRenderSize(8, 4);
  unsigned char* frame = getFramePointer();
  renderFrame();
  /* Azimuth -180, -135 ... 135 from the left, elevation -90, -45, 0, 45 from below. The eye
   * looks ahead to -z. */
  CHECK(shows(frame + 4 * (2 * 8 + 4), GREY, GREY, GREY)); /* ahead */
  CHECK(shows(frame + 4 * (2 * 8 + 6), 255, 0, 0));        /* right: +x */
  CHECK(shows(frame + 4 * (2 * 8 + 2), 0, 255, 0));        /* left */
  CHECK(shows(frame + 4 * (2 * 8 + 0), 0, 255, 255));      /* behind */
  CHECK(shows(frame + 4 * 5, 255, 255, 0));                /* below */
  setCurrentEyeShaderName("no such shader");
  renderFrame();
  CHECK(shows(frame + 4 * (2 * 8 + 4), GREY, GREY, GREY));

  setCurrentEyeShaderName("spherical_orientationwise_ids");
  renderFrame();
  CHECK(id_at(frame + 4 * (2 * 8 + 4)) == 0 && id_at(frame + 4 * (2 * 8 + 6)) == 2);
  CHECK(id_at(frame + 4 * 5) == 5);
  setCurrentEyeShaderName("spherical_positionwise_ids"); /* positions lie opposite to the axes */
  renderFrame();
  CHECK(id_at(frame + 4 * (2 * 8 + 4)) == 1 && id_at(frame + 4 * (2 * 8 + 6)) == 3);
  CHECK(id_at(frame + 4 * 5) == 4);
  setCurrentEyeShaderName("spherical_positionwise");
  renderFrame();
  CHECK(shows(frame + 4 * (2 * 8 + 4), 0, 255, 255));

  /* Half the width each: the left one of ommatidia with x < 0 (2, to +x) and ommatidium 0, which is
   * in both; the middle column belongs to neither. Each half starts at -180 degrees. */
  setCurrentEyeShaderName("spherical_split_orientationwise");
  renderFrame();
  CHECK(shows(frame + 4 * (2 * 8 + 3), 255, 0, 0));        /* left half, azimuth 90 */
  CHECK(shows(frame + 4 * (2 * 8 + 2), GREY, GREY, GREY)); /* left half, ahead */
  CHECK(shows(frame + 4 * (2 * 8 + 5), 0, 255, 0));        /* right half, azimuth -90 */
  CHECK(shows(frame + 4 * (2 * 8 + 6), GREY, GREY, GREY)); /* right half, ahead */
  CHECK(shows(frame + 4 * (2 * 8 + 4), GREY, GREY, GREY));

  setCurrentEyeShaderName("single_dimension");
  setRenderSize(12, 2);
  frame = getFramePointer();
  renderFrame();
  CHECK(shows(frame + 4 * (12 + 0), GREY, GREY, GREY) && shows(frame + 4 * 1, GREY, GREY, GREY));
  CHECK(shows(frame + 4 * 4, 255, 0, 0) && shows(frame + 4 * 11, 255, 255, 0));

  setCurrentEyeShaderName("single_dimension_fast");
  setRenderSize(7, 2);
  frame = getFramePointer();
  renderFrame();
  CHECK(shows(frame + 4 * 2, 255, 0, 0));
  CHECK(frame[4 * 6 + 3] == 0 && frame[4 * 7 + 3] == 0); /* untouched */
  setRenderSize(2, 1);                                   /* too narrow for all */
  renderFrame();

  /* Raw samples: column ommatidium, row sample, each its share of the mean: 1/4 of 0.5 and of 1. */
  setCurrentEyeSamplesPerOmmatidium(4);
  setCurrentEyeShaderName("raw_ommatidial_samples");
  setRenderSize(7, 6);
  frame = getFramePointer();
  renderFrame();
  const int share = 135; /* trunc(255 * 0.25^(1/2.2)) */
  for (int row = 0; row < 4; ++row) CHECK(shows(frame + 4 * (row * 7 + 2), share, 0, 0));
  CHECK(frame[4 * (4 * 7) + 3] == 0 && frame[4 * 6 + 3] == 0);
}

static void other_ommatidia(void) {
  gotoCameraByName("vector");
  setRenderSize(3, 1);
  unsigned char* frame = getFramePointer();
  /* One to the right; one down; one that looks at the edge of two walls with 60 degrees. The frame
   * is that of the eye file, z forward. */
  OmmatidiumPacket packets[3] = {
      {0, 0, 0, 1, 0, 0, 0, 0}, {0, 0, 0, 0, -3, 0, 0.1f, 0.01f}, {0, 0, 0, 1, 0, 1, 1.0472f, 0}};
  setOmmatidia(packets, 3);
  CHECK(getCurrentEyeOmmatidialCount() == 3);
  CHECK(strlen(getCurrentEyeDataPath()) > 0); /* of the file that it once was */
  renderFrame();
  CHECK(shows(frame, 255, 0, 0) && shows(frame + 4, 255, 255, 0));
  int red = 0, grey = 0;
  for (int i = 0; i < 100; ++i) { /* new samples each time */
    renderFrame();
    red += shows(frame + 8, 255, 0, 0);
    grey += shows(frame + 8, GREY, GREY, GREY);
  }
  CHECK(red > 20 && grey > 20); /* half each, but for the floor's and ceiling's; 20 is 5 sd off */
  packets[1].dirY = 0;
  setOmmatidia(packets, 2); /* no direction: stays */
  setOmmatidia(packets, 0);
  setOmmatidia(NULL, 4);
  CHECK(getCurrentEyeOmmatidialCount() == 3);
  gotoCameraByName("insect");
  CHECK(getCurrentEyeOmmatidialCount() == 6); /* each eye its own, its samples too */
  CHECK(getCurrentEyeSamplesPerOmmatidium() == 4);
}

static void geometry(void) {
  const float root = sqrtf(2);
  const float3 most = getGeometryMaxBounds("box"), least = getGeometryMinBounds("box");
  CHECK(fabsf(most.x - (2 + root)) < 1e-5f && fabsf(most.y - 1) < 1e-5f);
  CHECK(fabsf(most.z - root) < 1e-5f && fabsf(least.x - (2 - root)) < 1e-5f);
  CHECK(fabsf(getGeometryMinBounds("wall +x").x - 10) < 1e-5f);
  CHECK(fabsf(getGeometryMinBounds("wall +x").z + 10) < 1e-5f);
  CHECK(getGeometryMaxBounds("nothing").x == 0 && getGeometryMaxBounds(NULL).z == 0);
  CHECK(isInsideHitGeometry(2, 0, 0, "box"));
  CHECK(isInsideHitGeometry(3.2f, 0.5f, 0, "box")); /* it is turned by 45 degrees */
  CHECK(!isInsideHitGeometry(3, 0, 1, "box"));
  CHECK(!isInsideHitGeometry(2, 0, 0, "wall +x"));
  CHECK(!isInsideHitGeometry(2, 0, 0, NULL));
}

int main(int count, char** arguments) {
  if (count != 2) return 2;
  char scene[4096];
  snprintf(scene, sizeof scene, "%s/room.gltf", arguments[1]);
  without_a_scene();
  setVerbosity(false);
  loadGlTFscene(scene);
  cameras();
  pictures("compat_test_frame.ppm");
  loadGlTFscene(scene); /* anew */
  CHECK(getCurrentCameraIndex() == 0);
  poses();
  eyes();
  other_ommatidia();
  geometry();
  stop();
  renderFrame(); /* too late */
  CHECK(getCameraCount() == 6);
  stop();
  printf("%s\n", failures == 0 ? "all good" : "failed");
  return failures == 0 ? 0 : 1;
}
