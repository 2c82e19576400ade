//! `[sky]`: where on the sky the image is. Numbers are checked and copied; there is no ephemeris.

use super::document::{Node, Value};
use super::error::SceneError;
use super::source::Place;
use super::table::Table;
use crate::sky::{
    Pointing, STONYHURST, Sky, SkyCoordinates, SkyDate, SolarObserver, cross, dot,
    helioprojective_axes,
};
use crate::units::Unit;
use crate::words::alternatives;

/// What a sky has to fit to.
pub(crate) struct SkyView<'a> {
    /// The name of the camera.
    pub(crate) camera: &'a str,
    /// Whether its image has longitudes and latitudes about a pointing.
    pub(crate) is_celestial: bool,
    /// Whether its pixels are those of `HEALPix`.
    pub(crate) is_healpix: bool,
    pub(crate) pointing: Option<Pointing>,
    pub(crate) length_unit: Option<&'a str>,
}

const FRAME: &str = "the name of the frame whose axes are those of the model, such as \"ICRS\"";
const AXES: &str = "three directions [x, y, z] in `coordinates`, those of the model's x, y and z, at \
                    right angles to each other";
const DATE: &str = "a date and time in UTC, such as \"2024-04-08T18:00:00\"";
const EQUINOX: &str = "a Julian year, such as 2000.0";
const OBSERVER: &str = "a table { longitude, latitude, distance }: Stonyhurst's, in degrees, and a \
                        length in `length_unit`";
const LATITUDE: &str = "a latitude in degrees, -90 to 90";
const LENGTH: &str = "a length in `length_unit`, above 0";

/// The nominal radius of the Sun \[m\] (IAU 2015 resolution B3).
const SUN_RADIUS_M: f64 = 6.957e8;

/// How far axes may be from orthonormal ones: written with few digits they are made so.
const NOT_ORTHONORMAL: f64 = 1e-5;

/// How far the axes of a `HEALPix` map may be from those of its coordinates \[rad\].
const ALIGNED: f64 = 1e-9;

/// How far an observer may be from the position of the camera, relative to its distance.
const SAME_PLACE: f64 = 1e-6;

pub(super) fn read(mut table: Table, view: &SkyView<'_>) -> Result<Sky, SceneError> {
    let place = table.place().clone();
    if !view.is_celestial && !view.is_healpix {
        let message = format!("the camera `{}` has no celestial projection", view.camera);
        return Err(SceneError::at(&place, message)
            .label("expected `perspective`, `equirectangular`, `fisheye` or `healpix`"));
    }
    let (frame, of_frame) = table.require("frame", FRAME)?.text()?;
    if frame.is_empty() {
        return Err(
            SceneError::at(&of_frame, "`sky.frame` is empty").label(format!("expected {FRAME}"))
        );
    }
    let (coordinates, of_coordinates) = match table.text("coordinates")? {
        Some((name, place)) => (named(&name, &place)?, place),
        None => (SkyCoordinates::for_frame(&frame), of_frame.clone()),
    };
    let axes = table.take("axes");
    let equinox = table.take("equinox");
    let date = table.take("date");
    let observer = table.take("observer");
    let sun_radius = table.take("sun_radius");
    table.finish()?;

    let of = coordinates.description();
    if let (Some(node), false) = (&equinox, of.has_equinox) {
        return Err(SceneError::at(&node.place, format!("{} have no equinox", of.name))
            .label("expected none, or `coordinates` FK5 or BarycentricMeanEcliptic"));
    }
    let equinox = match equinox {
        Some(node) => Some(positive(&node, EQUINOX)?),
        None => of.has_equinox.then_some(2000.0),
    };
    let date = date.map(|node| read_date(&node)).transpose()?;
    let length = Length { unit: view.length_unit, place: &place };
    let given = observer.map(|node| read_observer(node, &length)).transpose()?;
    let is_solar = coordinates == SkyCoordinates::Helioprojective;
    if let (Some((_, place)), false) = (&given, is_solar) {
        return Err(SceneError::at(place, format!("{} have no observer", of.name))
            .label("expected none, or `coordinates` Helioprojective"));
    }
    let derived = if is_solar && axes.is_none() && frame == STONYHURST {
        Some(above_the_sun(view, &length, given.as_ref())?)
    } else {
        None
    };
    let (axes, observer) = match (axes, derived) {
        (Some(node), _) => (read_axes(&node, coordinates)?, given.map(|(observer, _)| observer)),
        (None, Some((axes, observer))) => (axes, Some(observer)),
        (None, None) if frame == of.name && !of.is_left_handed => (IDENTITY, None),
        (None, None) => return Err(axes_missing(&frame, of.name, &of_frame)),
    };
    if view.is_healpix && (of.healpix.is_none() || !are_aligned(axes)) {
        let message = "a HEALPix map has the axes of the model, for which there is no COORDSYS";
        return Err(SceneError::at(&of_coordinates, message).label(
            "expected the frame ICRS, Galactic or BarycentricMeanEcliptic, without `axes`",
        ));
    }
    let observer = match observer {
        Some(observer) => Some(with_radius(observer, sun_radius.as_ref(), &length)?),
        None if is_solar => {
            return Err(SceneError::at(&place, "`sky.observer` is missing")
                .label(format!("expected `observer` here: {OBSERVER}")));
        }
        None => None,
    };
    if let (Some(node), false) = (&sun_radius, is_solar) {
        return Err(SceneError::at(&node.place, format!("{} have no radius of the Sun", of.name))
            .label("expected none, or `coordinates` Helioprojective"));
    }
    if is_solar && date.is_none() {
        return Err(SceneError::at(&place, "`sky.date` is missing")
            .label(format!("expected `date` here: {DATE}")));
    }
    Ok(Sky { frame, coordinates, axes, equinox, date, observer })
}

fn named(name: &str, place: &Place) -> Result<SkyCoordinates, SceneError> {
    SkyCoordinates::named(name).ok_or_else(|| {
        let names = SkyCoordinates::ALL.map(|of| format!("`{}`", of.description().name));
        SceneError::at(place, format!("unknown coordinates `{name}`"))
            .label(format!("expected {}", alternatives(names)))
    })
}

fn axes_missing(frame: &str, coordinates: &str, place: &Place) -> SceneError {
    SceneError::at(place, "`sky.axes` is missing")
        .label(format!("expected `axes`: {AXES}"))
        .help(format!(
            "how the axes of {frame} lie in {coordinates} coordinates depends on more than is known \
             here: `camera.sky.table` of Python has them; no `axes` are needed where `frame` and \
             `coordinates` are the same, and for HeliographicStonyhurst"
        ))
}

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn are_aligned(axes: [[f64; 3]; 3]) -> bool {
    let pairs = axes.iter().flatten().zip(IDENTITY.iter().flatten());
    pairs.into_iter().all(|(a, b)| (a - b).abs() < ALIGNED)
}

/// The axes of the model, made orthonormal.
fn read_axes(node: &Node, coordinates: SkyCoordinates) -> Result<[[f64; 3]; 3], SceneError> {
    let Value::Array(rows) = &node.value else {
        return Err(node.refuse(node.value.kind(), AXES));
    };
    let rows: Vec<[f64; 3]> = rows.iter().map(|row| row.vector(AXES)).collect::<Result<_, _>>()?;
    let count = rows.len();
    let mut axes = <[[f64; 3]; 3]>::try_from(rows)
        .map_err(|_| node.refuse(&format!("an array of {count}"), AXES))?;
    let of = coordinates.description();
    let most = departure(axes);
    if most.is_nan() || most > NOT_ORTHONORMAL {
        let message =
            format!("`{}` are off by {most:.2e} from unit vectors at right angles", node.path);
        return Err(SceneError::at(&node.place, message).label(format!("expected {AXES}")));
    }
    let is_left = dot(axes[0], cross(axes[1], axes[2])) < 0.0;
    if is_left != of.is_left_handed {
        let [found, wanted] = [is_left, !is_left].map(|left| if left { "left" } else { "right" });
        let message = format!("`{}` are {found}-handed in {} coordinates", node.path, of.name);
        return Err(SceneError::at(&node.place, message).label(format!(
            "expected {wanted}-handed ones, so that the axes of the model are right-handed in space"
        )));
    }
    // Newton's iteration for the nearest orthonormal axes; those of full precision keep their bits.
    for _ in 0..4 {
        if departure(axes) <= 1e-14 {
            break;
        }
        let products = axes.map(|a| axes.map(|b| dot(a, b)));
        axes = core::array::from_fn(|i| {
            core::array::from_fn(|k| {
                let along: f64 = (0..3).map(|j| products[i][j] * axes[j][k]).sum();
                1.5 * axes[i][k] - 0.5 * along
            })
        });
    }
    Ok(axes)
}

/// How far axes are from orthonormal ones.
fn departure(axes: [[f64; 3]; 3]) -> f64 {
    let pairs = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
    let off = pairs.map(|(i, j)| (dot(axes[i], axes[j]) - IDENTITY[i][j]).abs());
    off.fold(0.0, |most: f64, off| if off.is_nan() { off } else { most.max(off) })
}

/// A date, as a string or as TOML has dates.
fn read_date(node: &Node) -> Result<SkyDate, SceneError> {
    let text = match &node.value {
        Value::Text(text) => text.as_str(),
        Value::Datetime => node.place.source.text.get(node.place.span.clone()).unwrap_or_default(),
        _ => return Err(node.refuse(node.value.kind(), DATE)),
    };
    SkyDate::parse(text).ok_or_else(|| node.refuse(&format!("`{text}`"), DATE))
}

/// Lengths of the scene in metres.
struct Length<'a> {
    unit: Option<&'a str>,
    /// Of the table `[sky]`.
    place: &'a Place,
}

impl Length<'_> {
    fn metres(&self) -> Result<f64, SceneError> {
        let factor = self.unit.and_then(|unit| {
            Unit::parse(unit).and_then(|unit| unit.factor_to(&Unit::parse("m")?)).ok()
        });
        factor.ok_or_else(|| {
            SceneError::at(self.place, "the scene has no `length_unit`")
                .label("expected `length_unit` in `[projection]`, such as \"R_sun\"")
        })
    }
}

fn positive(node: &Node, expected: &str) -> Result<f64, SceneError> {
    let number = node.number()?;
    if number > 0.0 { Ok(number) } else { Err(node.refuse(&number.to_string(), expected)) }
}

fn read_observer(node: Node, length: &Length<'_>) -> Result<(SolarObserver, Place), SceneError> {
    if !matches!(node.value, Value::Table(_)) {
        return Err(node.refuse(node.value.kind(), OBSERVER));
    }
    let place = node.place.clone();
    let mut table = Table::new(node)?;
    let longitude = table.require("longitude", "a longitude in degrees")?;
    let latitude = table.require("latitude", LATITUDE)?;
    let distance = table.require("distance", LENGTH)?;
    table.finish()?;
    let latitude_deg = latitude.number()?;
    if !(-90.0..=90.0).contains(&latitude_deg) {
        return Err(latitude.refuse(&latitude_deg.to_string(), LATITUDE));
    }
    let observer = SolarObserver {
        longitude_deg: longitude.number()?,
        latitude_deg,
        distance_m: positive(&distance, LENGTH)? * length.metres()?,
        sun_radius_m: SUN_RADIUS_M,
    };
    Ok((observer, place))
}

fn with_radius(
    mut observer: SolarObserver,
    radius: Option<&Node>,
    length: &Length<'_>,
) -> Result<SolarObserver, SceneError> {
    if let Some(node) = radius {
        observer.sun_radius_m = positive(node, LENGTH)? * length.metres()?;
    }
    if observer.distance_m <= observer.sun_radius_m {
        let place = radius.map_or(length.place, |node| &node.place);
        return Err(SceneError::at(
            place,
            format!(
                "the observer is {:.6e} m from the centre of the Sun, whose radius is {:.6e} m",
                observer.distance_m, observer.sun_radius_m
            ),
        )
        .label("expected an observer outside of the Sun"));
    }
    Ok(observer)
}

/// The axes of Stonyhurst's frame in helioprojective coordinates of the camera, and the camera as
/// their observer, who has to be there if one is given.
fn above_the_sun(
    view: &SkyView<'_>,
    length: &Length<'_>,
    given: Option<&(SolarObserver, Place)>,
) -> Result<([[f64; 3]; 3], SolarObserver), SceneError> {
    let metres = length.metres()?;
    let position = view.pointing.map_or([0.0; 3], |pointing| pointing.position);
    let axes = helioprojective_axes(position).ok_or_else(|| {
        let message =
            format!("`position` is {position:?}: helioprojective coordinates have no north there");
        SceneError::at(length.place, message)
            .label("expected an observer outside of the Sun and not above a pole, or `axes`")
    })?;
    let [x, y, z] = position;
    let at = SolarObserver {
        longitude_deg: y.atan2(x).to_degrees(),
        latitude_deg: z.atan2(x.hypot(y)).to_degrees(),
        distance_m: dot(position, position).sqrt() * metres,
        sun_radius_m: SUN_RADIUS_M,
    };
    let Some((observer, place)) = given else { return Ok((axes, at)) };
    let apart: f64 = {
        let [a, b] = [cartesian(observer), cartesian(&at)];
        (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
    };
    if apart > SAME_PLACE * at.distance_m {
        let message =
            format!("the observer is {apart:.3e} m from `position` of the camera, {position:?}");
        return Err(SceneError::at(place, message).label("expected one place, or no `observer`"));
    }
    Ok((axes, *observer))
}

fn cartesian(observer: &SolarObserver) -> [f64; 3] {
    let (sine, cosine) = observer.longitude_deg.to_radians().sin_cos();
    let (up, across) = observer.latitude_deg.to_radians().sin_cos();
    [across * cosine, across * sine, up].map(|along| along * observer.distance_m)
}

#[cfg(test)]
mod tests;
