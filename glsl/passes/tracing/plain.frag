#version 430
in vec3 plain_color;
out vec4 color;

void main() {
    color = vec4(plain_color, 1.0);
}
