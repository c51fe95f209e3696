// Phong per pixel for the raster preview, in eye space: x right, y up, the eye at the origin looking along -z.

// As `MOST_LIGHTS` in preview.rs.
const LIGHTS: u32 = 64u;
const FLAT: u32 = 1u;
const SRGB: u32 = 2u;
const ORTHOGRAPHIC: u32 = 4u;

struct Light {
    // Eye space; the last is unused.
    center: vec4f,
    color: vec4f,
}

struct Frame {
    view: mat4x4f,
    projection: mat4x4f,
    // Number of lights, flags, width and height of the picture in pixels.
    counts: vec4u,
    // Strength of the head light, factor of the lights, 2^exposure.
    strengths: vec4f,
    ambient: vec4f,
    lights: array<Light, LIGHTS>,
}

struct Material {
    ambient: vec4f,
    diffuse: vec4f,
    // The last is the exponent.
    specular: vec4f,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var diffuse_texture: texture_2d<f32>;
@group(1) @binding(2) var diffuse_sampler: sampler;

// What goes from corners to pixels is little: software cards pay for each number in each triangle. Where a pixel lies
// in eye space follows from its place on the screen.
struct Plain {
    @builtin(position) clip: vec4f,
    @location(0) normal: vec3f,
}

struct Full {
    @builtin(position) clip: vec4f,
    @location(0) normal: vec3f,
    @location(1) uv: vec2f,
    @location(2) color: vec4f,
}

fn clip_position(position: vec3f) -> vec4f {
    return frame.projection * (frame.view * vec4f(position, 1.0));
}

fn eye_normal(normal: vec3f) -> vec3f {
    return (frame.view * vec4f(normal, 0.0)).xyz;
}

@vertex
fn vertex_plain(@location(0) position: vec3f, @location(1) normal: vec3f) -> Plain {
    return Plain(clip_position(position), eye_normal(normal));
}

@vertex
fn vertex_full(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
) -> Full {
    return Full(clip_position(position), eye_normal(normal), uv, color);
}

// The point in eye space that a pixel shows.
fn eye_position(pixel: vec4f) -> vec3f {
    let size = vec2f(frame.counts.zw);
    let ndc = vec2f(2.0, -2.0) * pixel.xy / size + vec2f(-1.0, 1.0);
    let scale = vec2f(frame.projection[0][0], frame.projection[1][1]);
    if ((frame.counts.y & ORTHOGRAPHIC) != 0u) {
        return vec3f(ndc / scale, (pixel.z - frame.projection[3][2]) / frame.projection[2][2]);
    }
    let depth = 1.0 / pixel.w;
    return vec3f(ndc / scale * depth, -depth);
}

fn srgb_encode(c: vec3f) -> vec3f {
    let low = c * 12.92;
    let high = 1.055 * pow(max(c, vec3f(0.0)), vec3f(1.0 / 2.4)) - 0.055;
    return select(high, low, c <= vec3f(0.0031308));
}

fn encoded(linear: vec3f) -> vec4f {
    let cut = clamp(linear * frame.strengths.z, vec3f(0.0), vec3f(1.0));
    return vec4f(select(cut, srgb_encode(cut), (frame.counts.y & SRGB) != 0u), 1.0);
}

fn shaded(pixel: vec4f, normal: vec3f, kd: vec3f) -> vec4f {
    if ((frame.counts.y & FLAT) != 0u) {
        return encoded(kd);
    }
    let eye = eye_position(pixel);
    let to_viewer = select(-eye, vec3f(0.0, 0.0, 1.0), (frame.counts.y & ORTHOGRAPHIC) != 0u);
    let v = normalize(to_viewer);
    // Two-sided: the normal on the viewer's side.
    let n0 = normalize(normal);
    let n = select(-n0, n0, dot(n0, v) >= 0.0);
    let ks = material.specular.rgb;
    let exponent = max(material.specular.w, 1e-3);
    var sum = material.ambient.rgb * frame.ambient.rgb + frame.strengths.x * kd * max(dot(n, v), 0.0);
    for (var i = 0u; i < min(frame.counts.x, LIGHTS); i++) {
        let l = normalize(frame.lights[i].center.xyz - eye);
        let cosine = dot(n, l);
        if (cosine > 0.0) {
            let r = 2.0 * cosine * n - l;
            let highlight = pow(max(dot(r, v), 1e-6), exponent);
            sum += frame.strengths.y * frame.lights[i].color.rgb * (kd * cosine + ks * highlight);
        }
    }
    return encoded(sum);
}

@fragment
fn fragment_plain(in: Plain) -> @location(0) vec4f {
    return shaded(in.clip, in.normal, material.diffuse.rgb);
}

@fragment
fn fragment_full(in: Full) -> @location(0) vec4f {
    let texel = textureSample(diffuse_texture, diffuse_sampler, in.uv).rgb;
    return shaded(in.clip, in.normal, material.diffuse.rgb * texel * in.color.rgb);
}
