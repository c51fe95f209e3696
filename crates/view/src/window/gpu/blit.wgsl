// Shows a picture in the window, texel by pixel: cheaper than the window's own way where the processor draws.

@group(0) @binding(0) var picture: texture_2d<f32>;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
}

// Two triangles over the viewport, which is the picture's place.
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Varying {
    let corner = vec2f(f32(index & 1u), f32(index >> 1u));
    return Varying(vec4f(2.0 * corner.x - 1.0, 1.0 - 2.0 * corner.y, 0.0, 1.0), corner);
}

fn texel(uv: vec2f) -> vec4f {
    let size = vec2f(textureDimensions(picture));
    let at = clamp(floor(uv * size), vec2f(0.0), size - 1.0);
    return vec4f(textureLoad(picture, vec2i(at), 0).rgb, 1.0);
}

@fragment
fn fragment(in: Varying) -> @location(0) vec4f {
    return texel(in.uv);
}

// For windows that encode sRGB themselves.
@fragment
fn fragment_decoding(in: Varying) -> @location(0) vec4f {
    let shown = texel(in.uv).rgb;
    let high = pow((shown + 0.055) / 1.055, vec3f(2.4));
    return vec4f(select(high, shown / 12.92, shown <= vec3f(0.04045)), 1.0);
}
