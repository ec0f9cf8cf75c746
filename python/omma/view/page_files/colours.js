// The scene in the colours of Omma's pictures. three, which draws it, bends colours as film does
// (ACES) and encodes them as sRGB; Omma's pictures show each value to the power 1 / 2.2. Its shaders
// are changed on their way to the graphics card, as viser has no setting for it.
'use strict';
for (const kind of [window.WebGL2RenderingContext, window.WebGLRenderingContext]) {
  if (!kind) continue;
  const give = kind.prototype.shaderSource;
  kind.prototype.shaderSource = function (shader, source) {
    const plain = source
      .replace(/return ACESFilmicToneMapping\( ?color ?\)/, 'return color')
      .replace(/(vec4 linearToOutputTexel\( ?vec4 value ?\) ?\{\s*return) sRGBTransferOETF\(/,
        'vec4 ommaTransfer( vec4 value ) { return vec4( pow( clamp( value.rgb, 0.0, 1.0 ), ' +
        'vec3( 1.0 / 2.2 ) ), value.a ); }\n$1 ommaTransfer(');
    give.call(this, shader, plain);
  };
}
