// A finished picture, stretched over the canvas.
uniform sampler2D picture;
uniform vec2 canvasSize;
out vec4 colour;

void main() { colour = vec4(texture(picture, gl_FragCoord.xy / canvasSize).rgb, 1.0); }
