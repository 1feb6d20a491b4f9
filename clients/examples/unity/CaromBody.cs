// Put it beside a Collider: the body of Carom's scene that it sounds like.
using UnityEngine;

public sealed class CaromBody : MonoBehaviour
{
    public string like = "crate"; // a body of the score
    public float size = 1f; // in times that body's
    public string material = ""; // "": that body's
    public CaromScene scene;

    static int made;
    Rigidbody moves; // null: it is held
    string own;

    public int Number { get; private set; }

    void Start()
    {
        moves = GetComponent<Rigidbody>();
        Number = scene.Played.Body(like); // one that is held is the score's
        if (moves != null)
        {
            own = like + "." + ++made;
            string of = material == "" ? "" : " material " + material;
            string times = size.ToString(System.Globalization.CultureInfo.InvariantCulture);
            scene.Played.Send("/object/new " + own + " " + like + " size " + times + of);
            Number = scene.Played.Body(own);
        }
        scene.Add(this);
    }

    void OnDestroy()
    {
        scene.Remove(this);
        if (own != null && scene.Played != null) scene.Played.Send("/object/" + own + "/free");
    }

    public void Report()
    {
        if (moves == null || moves.IsSleeping()) return;
        scene.Played.Move(Number, CaromScene.Of(moves.worldCenterOfMass), CaromScene.Of(moves.rotation),
            CaromScene.Of(moves.velocity), CaromScene.Of(moves.angularVelocity));
    }

    void OnCollisionEnter(Collision met)
    {
        Touch(met, true);
    }

    void OnCollisionStay(Collision met)
    {
        Touch(met, false);
    }

    // Both bodies of a pair are called: the one of the higher number reports it.
    void Touch(Collision met, bool begins)
    {
        CaromBody other = met.collider.GetComponent<CaromBody>();
        if (other == null || other.Number > Number) return;
        for (int n = 0; n < met.contactCount; n++)
        {
            ContactPoint point = met.GetContact(n); // its normal leads from the other to this
            float speed = Mathf.Abs(Vector3.Dot(met.relativeVelocity, point.normal));
            float impulse = Mathf.Abs(Vector3.Dot(met.impulse, point.normal)) / met.contactCount;
            scene.Played.Touch(other.Number, Number, CaromScene.Of(point.point), CaromScene.Of(point.normal),
                begins ? float.NaN : impulse, begins ? speed : float.NaN);
        }
    }
}
