//! Missions drawn on a map: a GeoJSON `FeatureCollection` whose points are PoIs and whose
//! polygon, if it has one, is the fence. Everything else stands in its member `covey`.

use super::file::{Fault, MissionFile, fault};
use serde::Deserialize;

#[derive(Deserialize)]
pub(super) struct Collection {
    #[serde(rename = "type")]
    kind: Kind,
    covey: MissionFile,
    features: Vec<Feature>,
}

/// The only kind of document that is a mission.
#[derive(Deserialize)]
enum Kind {
    FeatureCollection,
}

#[derive(Deserialize)]
struct Feature {
    geometry: Option<Geometry>,
}

/// Positions are longitude, latitude and perhaps an altitude (RFC 7946, section 3.1.1).
#[derive(Deserialize)]
#[serde(tag = "type", content = "coordinates")]
enum Geometry {
    Point(Vec<f64>),
    MultiPoint(Vec<Vec<f64>>),
    Polygon(Vec<Vec<Vec<f64>>>),
}

impl Collection {
    pub(super) fn into_file(self) -> Result<MissionFile, Fault> {
        let Kind::FeatureCollection = self.kind;
        let mut file = self.covey;
        for (i, feature) in self.features.into_iter().enumerate() {
            let field = format!("features[{i}]");
            match feature.geometry {
                None => {}
                Some(Geometry::Point(point)) => file.pois_lat_lon.push(lat_lon(&field, &point)?),
                Some(Geometry::MultiPoint(points)) => {
                    for point in &points {
                        file.pois_lat_lon.push(lat_lon(&field, point)?);
                    }
                }
                Some(Geometry::Polygon(rings)) => {
                    let [ring] = &rings[..] else {
                        return Err(fault(&field, "is a polygon with holes; a fence has none"));
                    };
                    if file.fence.polygon_lat_lon.is_some() {
                        return Err(fault(&field, "is a second polygon; a mission has one fence"));
                    }
                    let corners = ring.iter().map(|p| lat_lon(&field, p)).collect::<Result<_, _>>()?;
                    file.fence.polygon_lat_lon = Some(corners);
                }
            }
        }
        Ok(file)
    }
}

fn lat_lon(field: &str, position: &[f64]) -> Result<[f64; 2], Fault> {
    match position {
        &[lon, lat] | &[lon, lat, _] => Ok([lat, lon]),
        other => Err(fault(field, format!("has a position of {} numbers; give longitude and latitude", other.len()))),
    }
}

#[cfg(test)]
mod tests {
    use crate::mission::Mission;
    use std::path::Path;

    fn read(features: &str) -> Result<Mission, String> {
        let text = format!(
            r#"{{"type":"FeatureCollection","covey":{{"origin":{{"lat":47.4,"lon":8.5,"alt_m":400}}}},"features":[{features}]}}"#
        );
        Mission::from_geojson(&text, Path::new("m.geojson")).map_err(|e| e.to_string())
    }

    fn feature(kind: &str, coordinates: &str) -> String {
        format!(r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"{kind}","coordinates":{coordinates}}}}}"#)
    }

    #[test]
    fn points_are_pois_and_the_polygon_is_the_fence() {
        let fence = feature("Polygon", "[[[8.5,47.4],[8.51,47.4],[8.51,47.41],[8.5,47.4]]]");
        let pois = feature("MultiPoint", "[[8.501,47.401],[8.502,47.401]]");
        let m = read(&[fence, feature("Point", "[8.501,47.402,500]"), pois].join(",")).unwrap();
        assert_eq!((m.pois.len(), m.fence.len()), (3, 3));
        assert!(m.pois[0].y > m.pois[1].y && m.pois[2].x > m.pois[1].x);
    }

    #[test]
    fn what_is_no_mission_is_refused_with_its_place() {
        let point = feature("Point", "[8.501,47.401]");
        let message = |features: &[&str]| read(&features.join(",")).unwrap_err();
        assert!(message(&[&point, &feature("Point", "[47.4,8.5]")]).contains("pois_lat_lon[1]"));
        assert!(message(&[&feature("Point", "[8.5]")]).contains("features[0] has a position of 1 numbers"));
        assert!(message(&[&feature("LineString", "[]")]).contains("unknown variant `LineString`"));
        let polygon = feature("Polygon", "[[[8.5,47.4],[8.51,47.4],[8.51,47.41]]]");
        assert!(message(&[&point, &polygon, &polygon]).contains("features[2] is a second polygon"));
    }
}
