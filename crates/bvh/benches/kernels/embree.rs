//! Embree 4, loaded at run time from the shared library that `EMBREE_LIB` names. Nothing else of the project knows it.
//!
//! All `unsafe` of this bench that is not the clock's stands here. It rests on three things: the library is Embree 4
//! (its symbols are looked up by name and its version is checked), the structures of [`crate::packets`] are laid out as
//! its header says, and buffers that a scene shares live as long as the scene.

use crate::measure::Kernel;
use crate::meshes::Mesh;
use crate::packets::{Lanes, Packet, Single, WIDTH};
use libloading::Library;
use penombre_bvh::{Hit, Ray};
use penombre_math::Vec3;
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::mem::ManuallyDrop;
use std::path::PathBuf;
use std::ptr::null_mut;
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};
use std::time::Instant;

type Handle = *mut c_void;
type Single1 = unsafe extern "C" fn(Handle, *mut Single, *mut c_void);
type Packet16 = unsafe extern "C" fn(*const Lanes, Handle, *mut Packet, *const Arguments);
type Monitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;

const GEOMETRY_TRIANGLE: c_int = 0;
const BUFFER_INDEX: c_int = 0;
const BUFFER_VERTEX: c_int = 1;
const FORMAT_UINT3: c_int = 0x5003;
const FORMAT_FLOAT3: c_int = 0x9003;
const SCENE_ROBUST: c_int = 4;
const FLAG_COHERENT: c_uint = 1 << 16;
const PROPERTY_VERSION: c_int = 0;
const OLDEST_VERSION: isize = 40_000;
const NEWEST_VERSION: isize = 49_999;

/// Two threads, for building; rays are traced by whoever calls.
const DEVICE: &[u8] = b"threads=2\0";

/// Bytes that Embree holds, by its own count.
static HELD: AtomicIsize = AtomicIsize::new(0);

unsafe extern "C" fn count_bytes(_user: *mut c_void, bytes: isize, _after: bool) -> bool {
    HELD.fetch_add(bytes, Ordering::Relaxed);
    true
}

/// Embree's `RTCIntersectArguments` and `RTCOccludedArguments`, with room for what some builds append.
#[repr(C)]
struct Arguments {
    flags: c_uint,
    features: c_uint,
    pointers: [*mut c_void; 3],
    room: [u64; 4],
}

impl Arguments {
    /// All features, no callbacks; rays that go the same way, or not.
    fn new(coherent: bool) -> Self {
        Self {
            flags: if coherent { FLAG_COHERENT } else { 0 },
            features: c_uint::MAX,
            pointers: [null_mut(); 3],
            room: [0; 4],
        }
    }
}

/// The functions of Embree that are used here.
struct Api {
    new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    release_device: unsafe extern "C" fn(Handle),
    device_error: unsafe extern "C" fn(Handle) -> c_int,
    device_property: unsafe extern "C" fn(Handle, c_int) -> isize,
    monitor: unsafe extern "C" fn(Handle, Monitor, *mut c_void),
    new_geometry: unsafe extern "C" fn(Handle, c_int) -> Handle,
    release_geometry: unsafe extern "C" fn(Handle),
    share_buffer: unsafe extern "C" fn(Handle, c_int, c_uint, c_int, *const c_void, usize, usize, usize),
    geometry_quality: unsafe extern "C" fn(Handle, c_int),
    commit_geometry: unsafe extern "C" fn(Handle),
    new_scene: unsafe extern "C" fn(Handle) -> Handle,
    release_scene: unsafe extern "C" fn(Handle),
    scene_quality: unsafe extern "C" fn(Handle, c_int),
    scene_flags: unsafe extern "C" fn(Handle, c_int),
    attach: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    commit_scene: unsafe extern "C" fn(Handle),
    intersect1: Single1,
    occluded1: Single1,
    intersect16: Packet16,
    occluded16: Packet16,
    /// The code that all of these point into. It is never unloaded: its threads may outlive the device.
    _library: ManuallyDrop<Library>,
}

impl Api {
    fn load(path: &PathBuf) -> Result<Self, String> {
        // SAFETY: loading runs the library's initialisers; the person who set EMBREE_LIB vouches for the file.
        let library = unsafe { Library::new(path) }.map_err(|e| format!("EMBREE_LIB: {e}"))?;
        macro_rules! symbol {
            ($name:literal) => {
                // SAFETY: the field that this goes to has the signature that Embree 4's header gives this function;
                // the pointer is used only while `_library` lives in the same structure.
                *unsafe { library.get($name) }.map_err(|e| format!("EMBREE_LIB is not Embree 4: {e}"))?
            };
        }
        Ok(Self {
            new_device: symbol!(b"rtcNewDevice\0"),
            release_device: symbol!(b"rtcReleaseDevice\0"),
            device_error: symbol!(b"rtcGetDeviceError\0"),
            device_property: symbol!(b"rtcGetDeviceProperty\0"),
            monitor: symbol!(b"rtcSetDeviceMemoryMonitorFunction\0"),
            new_geometry: symbol!(b"rtcNewGeometry\0"),
            release_geometry: symbol!(b"rtcReleaseGeometry\0"),
            share_buffer: symbol!(b"rtcSetSharedGeometryBuffer\0"),
            geometry_quality: symbol!(b"rtcSetGeometryBuildQuality\0"),
            commit_geometry: symbol!(b"rtcCommitGeometry\0"),
            new_scene: symbol!(b"rtcNewScene\0"),
            release_scene: symbol!(b"rtcReleaseScene\0"),
            scene_quality: symbol!(b"rtcSetSceneBuildQuality\0"),
            scene_flags: symbol!(b"rtcSetSceneFlags\0"),
            attach: symbol!(b"rtcAttachGeometry\0"),
            commit_scene: symbol!(b"rtcCommitScene\0"),
            intersect1: symbol!(b"rtcIntersect1\0"),
            occluded1: symbol!(b"rtcOccluded1\0"),
            intersect16: symbol!(b"rtcIntersect16\0"),
            occluded16: symbol!(b"rtcOccluded16\0"),
            _library: ManuallyDrop::new(library),
        })
    }
}

/// The library with one device.
pub struct Embree {
    api: Api,
    device: Handle,
}

impl Embree {
    /// The library that `EMBREE_LIB` names; nothing if the variable is not set.
    pub fn from_environment() -> Result<Option<Self>, String> {
        let Some(path) = std::env::var_os("EMBREE_LIB").filter(|p| !p.is_empty()) else { return Ok(None) };
        let api = Api::load(&path.into())?;
        // SAFETY: the configuration is a string that ends with NUL.
        let device = unsafe { (api.new_device)(DEVICE.as_ptr().cast()) };
        if device.is_null() {
            return Err("Embree makes no device".into());
        }
        let embree = Self { api, device };
        let number = embree.version_number();
        if !(OLDEST_VERSION..=NEWEST_VERSION).contains(&number) {
            return Err(format!("EMBREE_LIB is version {number} of Embree, not 4"));
        }
        // SAFETY: the device lives; the callback has the signature asked for and uses no user data.
        unsafe { (embree.api.monitor)(device, count_bytes, null_mut()) };
        Ok(Some(embree))
    }

    /// Its version, such as 4.4.0.
    pub fn version(&self) -> String {
        let number = self.version_number();
        format!("{}.{}.{}", number / 10_000, number / 100 % 100, number % 100)
    }

    fn version_number(&self) -> isize {
        // SAFETY: the device lives; the property is one that all versions have.
        unsafe { (self.api.device_property)(self.device, PROPERTY_VERSION) }
    }

    /// Builds a scene of one mesh.
    pub fn build(&self, mesh: &Arc<Shared>, how: Build) -> Result<Scene<'_>, String> {
        let (held, start) = (HELD.load(Ordering::Relaxed), Instant::now());
        // SAFETY: the device lives as long as the scene, which borrows `self`.
        let handle = unsafe { (self.api.new_scene)(self.device) };
        let mut scene = Scene { embree: self, handle, _mesh: Arc::clone(mesh), seconds: 0.0, bytes: 0 };
        self.fill(handle, mesh, how);
        scene.seconds = start.elapsed().as_secs_f64();
        scene.bytes = HELD.load(Ordering::Relaxed).saturating_sub(held).max(0) as usize;
        // SAFETY: the device lives.
        match unsafe { (self.api.device_error)(self.device) } {
            0 => Ok(scene),
            code => Err(format!("Embree could not build: error {code}")),
        }
    }

    fn fill(&self, scene: Handle, mesh: &Shared, how: Build) {
        let api = &self.api;
        // SAFETY: all handles live: the geometry until it is released, when the scene holds it. The buffers have the
        // formats, strides and counts said, vertices have 16 readable bytes behind the last, and the scene keeps `mesh`.
        unsafe {
            let geometry = (api.new_geometry)(self.device, GEOMETRY_TRIANGLE);
            let (vertices, indices) = (mesh.vertices.as_ptr().cast(), mesh.indices.as_ptr().cast());
            (api.share_buffer)(
                geometry,
                BUFFER_VERTEX,
                0,
                FORMAT_FLOAT3,
                vertices,
                0,
                12,
                mesh.vertex_count(),
            );
            (api.share_buffer)(geometry, BUFFER_INDEX, 0, FORMAT_UINT3, indices, 0, 12, mesh.indices.len());
            (api.geometry_quality)(geometry, how.quality());
            (api.commit_geometry)(geometry);
            (api.scene_quality)(scene, how.quality());
            (api.scene_flags)(scene, how.flags());
            (api.attach)(scene, geometry);
            (api.release_geometry)(geometry);
            (api.commit_scene)(scene);
        }
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: the device lives, and no scene borrows it any more.
        unsafe { (self.api.release_device)(self.device) };
    }
}

/// How a scene is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Build {
    /// Medium quality.
    Medium,
    /// High quality: with spatial splits.
    High,
    /// High quality and watertight. Embree makes no spatial splits then.
    Robust,
}

impl Build {
    fn quality(self) -> c_int {
        if self == Self::Medium { 1 } else { 2 }
    }

    fn flags(self) -> c_int {
        if self == Self::Robust { SCENE_ROBUST } else { 0 }
    }
}

/// Buffers that scenes share with us.
pub struct Shared {
    /// With [`Shared::BEHIND`] more behind the last: Embree reads up to 16 bytes from each vertex.
    vertices: Vec<[f32; 3]>,
    indices: Vec<[u32; 3]>,
}

impl Shared {
    const BEHIND: usize = 2;

    /// Copies a mesh.
    pub fn new(mesh: &Mesh) -> Arc<Self> {
        assert!(mesh.has_valid_indices(), "Embree does not check them");
        let points = mesh.positions.iter().copied().chain([Vec3::ZERO; Self::BEHIND]);
        Arc::new(Self { vertices: points.map(|p| p.to_array()).collect(), indices: mesh.indices.clone() })
    }

    fn vertex_count(&self) -> usize {
        self.vertices.len() - Self::BEHIND
    }
}

/// A built scene.
pub struct Scene<'a> {
    embree: &'a Embree,
    handle: Handle,
    _mesh: Arc<Shared>,
    /// Wall time of its build with two threads.
    pub seconds: f64,
    /// Memory that it holds, by Embree's own count.
    pub bytes: usize,
}

impl Scene<'_> {
    fn single(&self, call: Single1, ray: &Ray) -> Single {
        let mut single = Single::new(ray);
        // SAFETY: the scene is committed; the ray is aligned and as large as `RTCRayHit`; no arguments are allowed.
        unsafe { call(self.handle, &raw mut single, null_mut()) };
        single
    }

    fn packet(&self, call: Packet16, rays: &[Ray], packet: &mut Packet, how: &Arguments) {
        packet.load(rays);
        let lanes = Lanes::first(rays.len());
        // SAFETY: as above, for 16 rays; lanes without a ray are said to be so.
        unsafe { call(&raw const lanes, self.handle, packet, how) };
    }
}

impl Drop for Scene<'_> {
    fn drop(&mut self) {
        // SAFETY: the scene lives, and so does its device.
        unsafe { (self.embree.api.release_scene)(self.handle) };
    }
}

/// One ray a call.
pub struct One<'a>(pub &'a Scene<'a>);

/// 16 rays a call, said to go the same way or not.
pub struct Sixteen<'a> {
    scene: &'a Scene<'a>,
    arguments: Arguments,
}

impl<'a> Sixteen<'a> {
    /// Calls to a scene.
    pub fn new(scene: &'a Scene<'a>, coherent: bool) -> Self {
        Self { scene, arguments: Arguments::new(coherent) }
    }
}

impl Kernel for One<'_> {
    fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        let call = self.0.embree.api.intersect1;
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.0.single(call, ray).hit();
        }
    }

    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
        let call = self.0.embree.api.occluded1;
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = self.0.single(call, ray).is_blocked();
        }
    }
}

impl Kernel for Sixteen<'_> {
    fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        let call = self.scene.embree.api.intersect16;
        let mut packet = Packet::empty();
        for (rays, hits) in rays.chunks(WIDTH).zip(hits.chunks_mut(WIDTH)) {
            self.scene.packet(call, rays, &mut packet, &self.arguments);
            hits.iter_mut().enumerate().for_each(|(lane, hit)| *hit = packet.hit(lane));
        }
    }

    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
        let call = self.scene.embree.api.occluded16;
        let mut packet = Packet::empty();
        for (rays, blocked) in rays.chunks(WIDTH).zip(blocked.chunks_mut(WIDTH)) {
            self.scene.packet(call, rays, &mut packet, &self.arguments);
            blocked.iter_mut().enumerate().for_each(|(lane, blocked)| *blocked = packet.is_blocked(lane));
        }
    }
}
